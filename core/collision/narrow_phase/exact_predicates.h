// Signs of determinants of points, exact for any doubles that neither overflow nor underflow: a
// floating-point filter, then sums of doubles without rounding (expansions) [Shewchuk1997].
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Sign of det(a - d, b - d, c - d): +1 where d sees a, b, c clockwise (from below the
// counter-clockwise side), -1 on the other side, 0 where the four are in one plane.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// Sign of the area of a, b, c in the plane that is left when coordinate `dropped` is: +1
// counter-clockwise for axes in the order that follows `dropped` cyclically.
int orientation_in_plane(const Vec3& a, const Vec3& b, const Vec3& c, int dropped);

// Do the closed triangles share a point? Touching counts. Exact, also where they lie in one plane;
// two triangles that are both without area are not looked at.
bool triangles_meet(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                    const Vec3& b2);

}  // namespace loomstone
