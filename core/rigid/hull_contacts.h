// Where convex polyhedra touch surfaces of triangles, before any engine sees it.
#pragma once

#include <array>
#include <vector>

#include "core/rigid/polyhedron.h"

namespace loomstone {

struct HullContact {
  Vec3 point;   // on the triangle [m]
  Vec3 normal;  // from the triangle to the hull, unit length
  double gap;   // along it, negative where they overlap [m]

  Vec3 on_hull() const { return point + gap * normal; }
};

// Contacts of a hull with triangles in its own axes, by separating axes [Gottschalk1996] and
// clipped faces; a triangle turns its face to the side it touched the hull on in the step before,
// else to that where the hull's centre is. An edge or a corner of a triangle is met only in
// directions in which none of the triangles that share it (their coordinates are equal bit for bit)
// reaches farther: what slides over a plane is not held up by the edges within it.
class HullOnTriangles {
 public:
  using Corners = std::array<Vec3, 3>;
  using Contacts = std::vector<HullContact>;

  // Those with a gap of at most `near`, of each plane up to four that lie far apart, in up to
  // `most` planes, the deepest first. The first `n_met` triangles are met, those after them only
  // share edges with these. `before`: the contacts of the step before, where they are on the hull;
  // of two that bear as well those stay.
  void find(const Polyhedron& hull, const std::vector<Corners>& triangles, std::size_t n_met,
            double near, std::size_t most, const Contacts& before, std::vector<Contacts>& planes);

 private:
  // The direction from triangle to hull in which they are farthest apart or overlap least, and what
  // meets in it.
  struct Axis {
    Vec3 direction;
    double gap;
    Index face = -1, edge = -1;  // of the hull; none: the triangle's own plane
    bool met = true;             // false where a neighbour of the triangle reaches farther
    Vec3 point = Vec3::Zero();   // of the triangle, but where its own plane is met
  };
  // Whether nothing that shares the corners of a triangle which `among` names (bits) reaches
  // farther.
  bool reaches_farthest(const Vec3& direction, const Corners& triangle, unsigned among) const;
  // The two of all axes and of those that may be met (its own plane always may) in which a triangle
  // overlaps least. False where it is apart by more than `near`, or by any axis though it overlaps
  // by these.
  bool least_overlap(const Corners& triangle, const Vec3& normal, double near, Axis& best,
                     Axis& met) const;
  // Adds the contacts of a triangle that is met in a direction.
  void touch(const Corners& triangle, const Vec3& normal, double near, const Axis& axis);
  void clip_hull(const Corners& triangle, const Vec3& normal, double near);
  void clip_triangle(const Corners& triangle, Index face, const Vec3& normal, double near);

  const Polyhedron* hull_ = nullptr;
  const std::vector<Corners>* triangles_ = nullptr;
  Contacts contacts_;
  std::vector<Vec3> polygon_, clipped_;
};

}  // namespace loomstone
