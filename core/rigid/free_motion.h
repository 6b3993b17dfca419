// Free rotation of rigid bodies. The angular momentum in world axes, which is constant without
// torques, is an input. Only the orientation changes.
#pragma once

#include "core/base/rotation.h"
#include "core/base/types.h"

namespace loomstone {

struct Rotor {
  Mat3 axes = Mat3::Identity();  // columns: principal axes of inertia in the body's axes
  Vec3 moments = Vec3::Ones();   // moments of inertia about the principal axes [kg m^2]
};

// Computes principal axes and moments. The inertia is about the centre of mass, in body axes
// [kg m^2].
Rotor make_rotor(const Mat3& inertia);

// Converts angular velocity [rad/s] to angular momentum L [kg m^2/s] and back, in world axes.
Vec3 angular_momentum(const Rotor& rotor, const Vec4& orientation, const Vec3& angular_velocity);
Vec3 angular_velocity(const Rotor& rotor, const Vec4& orientation, const Vec3& angular_momentum);

// Returns the orientation after `step` [s] of free rotation with the angular momentum L. A, B and C
// are the moments of inertia about the principal axes a, b and c; L_a and L_c are the components of
// L along a and c. The three terms of the kinetic energy
//   L.L/2B + (1/A - 1/B) L_a^2/2 + (1/C - 1/B) L_c^2/2
// cause rotations about L, about axis a and about axis c. These are applied in the symmetric order
// of [Dullweber1997]. The method is reversible, of second order, and exact for bodies with two
// equal moments of inertia.
Vec4 freely_turned(const Rotor& rotor, const Vec4& orientation, const Vec3& angular_momentum,
                   double step);

}  // namespace loomstone
