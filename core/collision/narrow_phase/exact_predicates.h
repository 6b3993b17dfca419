// Exact geometric predicates: signs of determinants of points, for any doubles whose products
// neither overflow nor underflow. A floating-point filter, then expansions [Shewchuk1997].
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Sign of det(a - d, b - d, c - d): +1 if d sees a, b, c clockwise, -1 on the other side, 0 if the
// four points are coplanar.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// Sign of the area of a, b, c projected along coordinate `dropped`: +1 if counter-clockwise in the
// axes that follow `dropped` cyclically.
int orientation_in_plane(const Vec3& a, const Vec3& b, const Vec3& c, int dropped);

// Whether the closed triangles share a point. Exact; touching counts, coplanar triangles included.
// False if both triangles are degenerate.
bool triangles_meet(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                    const Vec3& b2);

}  // namespace loomstone
