// Orients the normals of the triangles of a surface towards the side on which a hull lies.
// Independent of Bullet.
#pragma once

#include <array>
#include <vector>

#include "core/rigid/contacts/hull_contacts.h"
#include "core/rigid/contacts/shared_corners.h"

namespace loomstone {

struct FacingQuery {
  const std::vector<std::array<Vec3, 3>>& triangles;
  const SharedCorners& shared;  // of these triangles
  const Vec3& centre;           // of the hull
  // Contacts of the previous step, whose `point` lies on the hull. A contact counts for every
  // triangle that is nearly perpendicular to the contact's normal and whose plane is less than
  // `reach` [m] from this point.
  const HullOnTriangles::Contacts& before;
  double reach;
};

// Returns, for each triangle, the unit normal that points to the hull's side of the surface, or
// zero if the triangle has no area. Triangles with common edges form a surface, and all of them
// face the same side of it. Each triangle first determines a side by its own plane: the side of the
// contact of the previous step that is closest to this plane (see FacingQuery::before) or, if there
// is none, that of the hull's centre. If the triangles of the surface contradict each other, the
// side is that of all contacts in the planes of its triangles or, if there are none or they
// contradict each other, that of the hull's centre. The surface normal at the point closest to the
// centre determines the side of the centre. At an edge, this normal is the mean of the normals of
// the two triangles; at a corner, it is the mean over the triangles there, weighted by their angles
// [BaerentzenAanaes2005]. A triangle therefore does not turn to a hull that lies behind the plane
// of the triangle but outside the surface. If the surface does not have two sides, or if the
// closest point lies on its boundary, each triangle keeps the side that it determined first.
std::vector<Vec3> facing_normals(const FacingQuery& query);

}  // namespace loomstone
