// The point of a triangle closest to a given one.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Which part of a triangle that is: its inside, the edge opposite `corner`, or that corner.
enum class TriangleFeature { Face, Edge, Corner };

struct TrianglePoint {
  Vec3 point, barycentric;
  TriangleFeature feature;
  int corner;
};

// By the regions of [Ericson2005], section 5.1.5; of a triangle without area the closest point of
// its edges.
TrianglePoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace loomstone
