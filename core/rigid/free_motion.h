// Rotation of bodies between contacts. The variable is angular momentum in world axes: torques add
// to it, and a free body keeps it to the last bit.
#pragma once

#include "core/base/rotation.h"
#include "core/base/types.h"

namespace loomstone {

struct Rotor {
  Mat3 axes = Mat3::Identity();  // columns: principal axes of inertia in the body's axes
  Vec3 moments = Vec3::Ones();   // moments of inertia about these axes [kg m^2]
};

// inertia: about the centre, body axes [kg m^2].
Rotor make_rotor(const Mat3& inertia);

// Angular momentum L [kg m^2/s] from angular velocity [rad/s] and back, world axes.
Vec3 angular_momentum(const Rotor& rotor, const Vec4& orientation, const Vec3& angular_velocity);
Vec3 angular_velocity(const Rotor& rotor, const Vec4& orientation, const Vec3& angular_momentum);

// Orientation after `step` [s] of free rotation. The kinetic energy L.L/2B + (1/A - 1/B) L_a^2/2 +
// (1/C - 1/B) L_c^2/2 is split into rotations about L, about axis a and about axis c, in the
// symmetric order of [Dullweber1997]: second order, reversible, exact for bodies with two equal
// moments.
Vec4 freely_turned(const Rotor& rotor, const Vec4& orientation, const Vec3& angular_momentum,
                   double step);

}  // namespace loomstone
