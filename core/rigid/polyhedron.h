// Convex polyhedra by their corners, faces and edges.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct Polyhedron {
  struct Face {
    Vec3 normal;    // outward, unit length
    double offset;  // normal . x of its plane [m]
  };
  struct Edge {
    std::array<Index, 2> points;
    std::array<Index, 2> faces;  // those it lies between
  };
  std::vector<Vec3> points;
  std::vector<Face> faces;
  std::vector<Edge> edges;  // but for those within a plane
  Vec3 centre;              // mean of the points

  // `loops`: the corners of each face in order round it.
  Polyhedron(const std::vector<Vec3>& points, const std::vector<std::vector<int>>& loops);
  // The points but for those within a face or an edge, which rounding leaves among a hull's.
  std::vector<Vec3> corners() const;
};
// With its centre at the origin.
Polyhedron box_polyhedron(const Vec3& half);

}  // namespace loomstone
