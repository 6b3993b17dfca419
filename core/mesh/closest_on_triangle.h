// The point of a triangle that is closest to a given point.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// The feature of a triangle on which the closest point lies: the interior (Face), the edge opposite
// TrianglePoint::corner (Edge), or that corner itself (Corner).
enum class TriangleFeature { Face, Edge, Corner };

struct TrianglePoint {
  Vec3 point, barycentric;
  TriangleFeature feature;
  int corner;
};

// Returns the point of triangle abc that is closest to p, by [Ericson2005], section 5.1.5 (Voronoi
// regions). If the triangle has zero area, this is the closest point on its edges.
TrianglePoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace loomstone
