// Forces and torques between bodies. The charge or current of one body is integrated in the exact
// field of the other; the reaction on the other follows from the balance of linear and angular
// momentum, which therefore holds to rounding.
//
// Dipoles and spheres need no integral, parallel cuboids have a closed form, and other bodies are
// integrated over their panels. Overlapping bodies feel the forces between their surface charges,
// which are finite.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

struct Wrench {
  Vec3 force = Vec3::Zero();   // [N]
  Vec3 torque = Vec3::Zero();  // about the centre of the body [N m]
  double error = 0.0;          // estimated error of the force and of torque / radius [N]
};

// Exerted on `on` by `by`. The error is at most `tolerance` times the larger of the force and
// `least` [N]; torques count divided by the radius of the body that is integrated over.
Wrench magnetic_wrench(const MagneticBody& on, const MagneticBody& by, double tolerance,
                       double least = 0.0);

// Field of a body that was evaluated at points in advance.
struct KnownField {
  MagneticBody body;
  Points points;           // (n x 3) [m]
  FieldAndGradient there;  // world axes
};

// Exerted on every body by all others. The error of each pair is at most `tolerance` times the
// largest force of any pair or on any single dipole. Spheres and other single dipoles act on one
// another by one sum, and exchange forces with each other body by its field at all of them. Sums
// run in a fixed order. carrier, if given: bodies with the same carrier exert no force on one
// another (forces between its single dipoles cancel in its sum). known: fields evaluated in
// advance, which change no bit.
std::vector<Wrench> magnetic_wrenches(const Team& team, const std::vector<MagneticBody>& bodies,
                                      double tolerance, const std::vector<Index>& carrier = {},
                                      const std::vector<KnownField>& known = {});

// Interaction energy of two bodies with constant magnetisation [J]; solid magnets and dipoles only.
double magnetic_energy(const MagneticBody& on, const MagneticBody& by, double tolerance);
// Sum of the energies of all pairs with different carriers [J].
double magnetic_energy(const Team& team, const std::vector<MagneticBody>& bodies, double tolerance,
                       const std::vector<Index>& carrier = {});

}  // namespace loomstone
