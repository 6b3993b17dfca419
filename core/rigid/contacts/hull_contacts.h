// Contacts of convex polyhedra with triangle surfaces. Independent of Bullet.
#pragma once

#include <array>
#include <vector>

#include "core/rigid/contacts/convex_polyhedron.h"
#include "core/rigid/contacts/shared_corners.h"

namespace loomstone {

struct HullContact {
  Vec3 point;   // point on the triangle [m]
  Vec3 normal;  // unit vector from the triangle to the hull
  double gap;   // gap along the normal, negative for overlaps [m]

  Vec3 on_hull() const { return point + gap * normal; }
};

// Finds the contacts of a hull with triangles by the separating-axis test [Gottschalk1996] and face
// clipping. The triangles are given in the axes of the hull. Each triangle faces the side of its
// surface on which the hull lies (facing_normals.h). An edge or corner of a triangle has contacts
// only in directions in which no other triangle at this edge or corner extends farther; for
// exceptions, see meet_triangles(). Triangles share an edge or corner if the coordinates of their
// corners are bitwise equal. Internal edges of a flat surface therefore do not block a hull that
// slides over it. The side of another obstacle whose top is flush with that surface does not block
// the hull either (`Query::flush`).
class HullOnTriangles {
 public:
  using Corners = std::array<Vec3, 3>;
  using Contacts = std::vector<HullContact>;

  struct Query {
    const ConvexPolyhedron& hull;
    const std::vector<Corners>& triangles;
    std::size_t n_met;  // the first n_met triangles can have contacts; others are only neighbours
    double near;        // largest gap of a contact [m]
    double flush;       // largest difference in height [m] of surfaces that count as flush
    std::size_t most;   // largest number of planes
    const Contacts& before;  // contacts of the previous step, whose `point` lies on the hull
  };
  // Finds the contacts and groups those with nearly equal normals into planes. Fills `planes` with
  // at most Query::most planes, those with the deepest contacts, in the order of decreasing depth.
  // Keeps at most four contacts in each plane.
  void find(const Query& query, std::vector<Contacts>& planes);

 private:
  // A direction from triangle to hull, the gap along it, and the features that meet.
  struct Axis {
    Vec3 direction;
    double gap;
    Index face = -1, edge = -1;  // of the hull; both -1 if the axis is the triangle's normal
    // False if a neighbouring triangle extends farther along the axis, or if the axis is opposite
    // to the triangle's normal. Contacts along such an axis are not admissible.
    bool met = true;
    Vec3 point = Vec3::Zero();  // contact point on the triangle; unused if face and edge are -1
  };
  // Returns true if no triangle that shares the corners `among` (a bit mask) of triangle t extends
  // beyond them along `direction`.
  bool reaches_farthest(const Vec3& direction, std::size_t t, unsigned among) const;
  // Returns the corner, among those of all triangles, that is farthest along a direction. Returns
  // `from` if no corner is farther than `from`.
  Vec3 farthest_corner(const Vec3& direction, const Vec3& from) const;
  // Determines two axes of least overlap of hull and triangle t: `best` among all candidates, and
  // `met` among the axes along which contacts are admissible. The normal of the triangle is always
  // admissible. The common normal of two edges is a candidate only if the nearest points of their
  // lines lie on the edges. Returns false if there is no contact. This is the case if the gap along
  // some axis exceeds `query.near`, or if hull and triangle overlap along `best` but are clearly
  // apart along an axis that is not a candidate. There is no contact either if the overlap along
  // `best` is at most `query.flush`, and hull and triangle would pass each other because they are
  // flush along an admissible axis at more than 45.6 degrees to `best`.
  bool least_overlap(const Query& query, std::size_t t, const Vec3& normal, Axis& best, Axis& met);
  // Fills contacts_ with the contacts of all triangles that can have contacts.
  void meet_triangles(const Query& query);
  // Adds the contacts between the hull and a triangle. They have the direction of `axis`. If `axis`
  // is nearly parallel to the triangle's `normal`, some or all have the direction of `normal`.
  void touch(const Corners& triangle, const Vec3& normal, double near, const Axis& axis);
  void clip_hull(const Corners& triangle, const Vec3& normal, double near);
  void clip_triangle(const Corners& triangle, Index face, const Vec3& normal, double near,
                     bool own);

  const ConvexPolyhedron* hull_ = nullptr;
  const std::vector<Corners>* triangles_ = nullptr;
  SharedCorners shared_;
  Contacts contacts_;
  std::vector<Vec3> flush_along_;
  std::vector<Vec3> polygon_, clipped_;
};

}  // namespace loomstone
