// Exact geometric predicates, which follow from signs of determinants of point coordinates.
// Coordinates may be any doubles whose products neither overflow nor underflow. A floating-point
// filter decides most signs. Exact sums of doubles (expansions, [Shewchuk1997]) decide the rest.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Returns the sign of det(a - d, b - d, c - d): +1 if a, b, c appear clockwise as seen from d, -1
// if they appear counter-clockwise, 0 if the four points are coplanar.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// Returns the sign of the area of a, b, c projected along coordinate `dropped`. It is +1 if the
// corners are counter-clockwise in the two axes that follow `dropped` cyclically.
int orientation_in_plane(const Vec3& a, const Vec3& b, const Vec3& c, int dropped);

// Returns whether the closed triangles have a common point. The result is exact, also for triangles
// that only touch and for coplanar triangles. Returns false if both triangles are degenerate.
bool triangles_meet(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                    const Vec3& b2);

}  // namespace loomstone
