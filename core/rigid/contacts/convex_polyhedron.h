// Convex polyhedra with points, faces and edges.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct ConvexPolyhedron {
  struct Face {
    Vec3 normal;    // outward, unit length
    double offset;  // normal . x for points x of the face plane [m]
  };
  struct Edge {
    std::array<Index, 2> points;
    std::array<Index, 2> faces;  // faces that meet at the edge
  };
  std::vector<Vec3> points;
  std::vector<Face> faces;
  std::vector<Edge> edges;  // excludes edges between coplanar faces
  Vec3 centre;              // mean of the points

  // `loops` lists the corners of each face in cyclic order, as indices of `points`. Seen from
  // outside, either all loops are counter-clockwise or all are clockwise.
  ConvexPolyhedron(const std::vector<Vec3>& points, const std::vector<std::vector<int>>& loops);
  // Returns the points that are true corners. Points inside a face or an edge, which rounding can
  // leave in a hull, are excluded.
  std::vector<Vec3> corners() const;
};
// A box with half edge lengths `half`, centred at the origin.
ConvexPolyhedron box_polyhedron(const Vec3& half);

}  // namespace loomstone
