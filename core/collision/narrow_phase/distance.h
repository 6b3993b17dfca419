// Closest points of a vertex and a triangle, and of two segments, including all degenerate cases.
// Weights are signed: + on side a (vertex, first edge), - on side b (face, second edge); each side
// sums to 1 in magnitude.
#pragma once

#include <array>

#include "core/base/types.h"

namespace loomstone {

struct ClosestPair {
  std::array<double, 4> weights;  // of the four points, in the order they were given
  Vec3 difference;                // from the closest point of b to that of a [m]
  double distance;                // [m]
  bool interior;                  // the closest points lie inside the face, or inside both edges
};

using FourPoints =
    std::array<Vec3, 4>;  // vertex, face corners; or the ends of edge a, then of edge b

ClosestPair closest_vertex_face(const FourPoints& points);
ClosestPair closest_edge_edge(const FourPoints& points);

// The distance [m], or infinity if the line of centres already proves it larger than `reach`.
double distance_within(bool vertex_face, const FourPoints& points, double reach);

// Unit normal from b to a. For a vanishing distance (below 1e-14 of the size) the difference of the
// closest points has no direction: the normal of the face, or the common perpendicular of the
// edges, oriented towards `side` (a vector from b to a at an earlier time, or zero), takes its
// place.
Vec3 contact_normal_vertex_face(const FourPoints& points, const ClosestPair& closest,
                                const Vec3& side);
Vec3 contact_normal_edge_edge(const FourPoints& points, const ClosestPair& closest,
                              const Vec3& side);

}  // namespace loomstone
