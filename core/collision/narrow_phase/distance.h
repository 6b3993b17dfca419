// Closest points of a vertex and a triangle, and of two segments, including degenerate cases.
// Weights are >= 0 for feature a (vertex, first edge) and <= 0 for feature b (face, second edge).
// The magnitudes of the weights of each feature sum to 1.
#pragma once

#include <array>

#include "core/base/types.h"

namespace loomstone {

struct ClosestPair {
  std::array<double, 4> weights;  // weights of the four points, in the order of FourPoints
  Vec3 difference;                // from the closest point of b to the closest point of a [m]
  double distance;                // [m]
  // True if the projection of the vertex onto the plane of the face lies in the face, or if the
  // closest points of the lines through the two edges lie on the edges. Sides and ends of the
  // features are included. Always false for a sliver face (height at most 1e-7 of the longest
  // edge), and may be false for nearly parallel edges.
  bool interior;
};

// The vertex and then the corners of the face, or the ends of edge a and then those of edge b.
using FourPoints = std::array<Vec3, 4>;

ClosestPair closest_vertex_face(const FourPoints& points);
ClosestPair closest_edge_edge(const FourPoints& points);

// Returns the distance between the two features [m]. Returns infinity instead if the projections of
// the features onto the line through their centroids prove that the distance exceeds `reach`.
double distance_within(bool vertex_face, const FourPoints& points, double reach);

// Both functions return the unit normal from b to a. If the distance is at most 1e-14 times the
// extent of the four points, the closest points define no direction. The result is then the face
// normal or the common perpendicular of the edges, oriented towards `side`, which is a vector from
// b to a at an earlier time, or zero. If the face normal or the perpendicular vanishes, the result
// is the direction of `side`, or z if `side` is zero.
Vec3 contact_normal_vertex_face(const FourPoints& points, const ClosestPair& closest,
                                const Vec3& side);
Vec3 contact_normal_edge_edge(const FourPoints& points, const ClosestPair& closest,
                              const Vec3& side);

}  // namespace loomstone
