// Where convex polyhedra touch surfaces of triangles, before any engine sees it.
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
};
// With its centre at the origin.
Polyhedron box_polyhedron(const Vec3& half);

struct HullContact {
  Vec3 point;   // on the triangle [m]
  Vec3 normal;  // from the triangle to the hull, unit length
  double gap;   // along it, negative where they overlap [m]
};

// Contacts of a hull with triangles in its own axes, by separating axes [Gottschalk1996] and clipped faces; a triangle turns its
// face to the side that the hull's centre is on. An edge or a corner of a triangle is met only in directions in which none of
// the triangles that share it (their coordinates are equal bit for bit) reaches farther: what slides over a plane is not held
// up by the edges within it.
class HullOnTriangles {
 public:
  // Those with a gap of at most `near`; of more than four those that lie farthest apart in one plane, or some of every plane.
  void find(const Polyhedron& hull, const std::vector<std::array<Vec3, 3>>& triangles, double near,
            std::vector<HullContact>& contacts);

 private:
  // The direction from triangle to hull in which they are farthest apart or overlap least, and what meets in it.
  struct Axis {
    Vec3 direction;
    double gap;
    Index face = -1, edge = -1;  // of the hull; with an edge
    int side = -1;               // of the triangle: from corner `side` to the next
    Vec3 point = Vec3::Zero();   // where that is met
  };
  bool reaches_farthest(const Vec3& direction, const Vec3& corner) const;
  bool reaches_farthest(const Vec3& direction, const Vec3& from, const Vec3& to) const;
  // False where there is a wider gap than `near`.
  bool least_overlap(const std::array<Vec3, 3>& triangle, const Vec3& normal, double near, Axis& best) const;
  void clip_hull(const std::array<Vec3, 3>& triangle, const Vec3& normal, double near, std::vector<HullContact>& contacts) const;
  void clip_triangle(const std::array<Vec3, 3>& triangle, Index face, const Vec3& normal, double near,
                     std::vector<HullContact>& contacts);

  const Polyhedron* hull_ = nullptr;
  const std::vector<std::array<Vec3, 3>>* triangles_ = nullptr;
  std::vector<Vec3> polygon_, clipped_;
};

}  // namespace loomstone
