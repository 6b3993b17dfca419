// Contacts of convex polyhedra with triangle surfaces. Independent of Bullet.
#pragma once

#include <array>
#include <vector>

#include "core/rigid/polyhedron.h"

namespace loomstone {

struct HullContact {
  Vec3 point;   // on the triangle [m]
  Vec3 normal;  // from the triangle to the hull, unit length
  double gap;   // along the normal, negative for overlaps [m]

  Vec3 on_hull() const { return point + gap * normal; }
};

// Contacts of a hull with triangles in its own axes, by separating axes [Gottschalk1996] and
// clipped faces. A triangle faces the side on which it touched the hull in the last step, else the
// side of the hull's centre. An edge or corner of a triangle has contacts only in directions in
// which none of the triangles that share it (their coordinates are equal bit for bit) reaches
// farther, so edges inside a plane do not obstruct a hull that slides over it.
class HullOnTriangles {
 public:
  using Corners = std::array<Vec3, 3>;
  using Contacts = std::vector<HullContact>;

  struct Query {
    const Polyhedron& hull;
    const std::vector<Corners>& triangles;
    std::size_t n_met;       // triangles that can have contacts; those after them only share edges
    double near;             // largest gap of a contact [m]
    std::size_t most;        // largest number of planes
    const Contacts& before;  // contacts of the last step, points on the hull; preferred if as good
  };
  // Finds up to four contacts that lie far apart in each plane, the deepest plane first.
  void find(const Query& query, std::vector<Contacts>& planes);

 private:
  // A direction from triangle to hull, their distance along it, and the features that meet.
  struct Axis {
    Vec3 direction;
    double gap;
    Index face = -1, edge = -1;  // of the hull; neither: the triangle's own plane
    bool met = true;             // false if a neighbour of the triangle reaches farther
    Vec3 point = Vec3::Zero();   // of the triangle, unless its own plane meets the hull
  };
  // Normal of a triangle towards the hull.
  Vec3 facing_normal(const Query& query, const Corners& triangle) const;
  // True if no triangle that shares the corners `among` (bits) of a triangle reaches farther.
  bool reaches_farthest(const Vec3& direction, const Corners& triangle, unsigned among) const;
  // The corner of all triangles that is farthest along a direction, at least as far as `from`.
  Vec3 farthest_corner(const Vec3& direction, const Vec3& from) const;
  // The axes of least overlap: `best` of all axes, `met` of those that can have contacts (the
  // triangle's own plane always can). False if the gap exceeds `near`, or if the two are apart
  // along some axis although they overlap along these two.
  bool least_overlap(const Corners& triangle, const Vec3& normal, double near, Axis& best,
                     Axis& met) const;
  // Fills contacts_.
  void meet_triangles(const Query& query);
  // Adds the contacts of a triangle along an axis.
  void touch(const Corners& triangle, const Vec3& normal, double near, const Axis& axis);
  void clip_hull(const Corners& triangle, const Vec3& normal, double near);
  void clip_triangle(const Corners& triangle, Index face, const Vec3& normal, double near);

  const Polyhedron* hull_ = nullptr;
  const std::vector<Corners>* triangles_ = nullptr;
  Contacts contacts_;
  std::vector<Vec3> polygon_, clipped_;
};

}  // namespace loomstone
