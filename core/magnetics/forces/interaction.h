// Forces and torques between bodies. One body's charge or current is integrated in the exact field
// of the other; what the other feels follows from the balance of linear and angular momentum, which
// is therefore kept to rounding.
//
// Dipoles and spheres need no integral, parallel cuboids have a closed form, others are integrated
// over their panels.
//
// Bodies that overlap feel the forces between their surface charges, which are finite.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

struct Wrench {
  Vec3 force = Vec3::Zero();   // [N]
  Vec3 torque = Vec3::Zero();  // about the body's own centre [N m]
  double error = 0.0;          // estimated, of the force and of torque / radius [N]
};

// On `on` by `by`, to `tolerance` times the larger of its force and of `least` [N]; torques count
// divided by the radius of the body that is integrated over.
Wrench magnetic_wrench(const MagneticBody& on, const MagneticBody& by, double tolerance,
                       double least = 0.0);

// The field of a source at points that are asked for again.
struct KnownField {
  MagneticBody body;
  Points points;           // (n x 3) [m]
  FieldAndGradient there;  // world axes
};

// On every body by all others, each pair to `tolerance` times the largest force of a pair, or of
// what spheres and other single dipoles feel and exert: these act on one another by one sum, and on
// a body by its field at all of them. Sums run in order. carrier, if given: bodies of the same
// carrier feel nothing from one another (what single dipoles of one carrier feel cancels in its
// sum). known: fields that were evaluated before; the same bits without them.
std::vector<Wrench> magnetic_wrenches(const Team& team, const std::vector<MagneticBody>& bodies,
                                      double tolerance, const std::vector<Index>& carrier = {},
                                      const std::vector<KnownField>& known = {});

// Energy of two bodies in one another's field, of `on` held in that of `by` [J]; solid magnets and
// dipoles only.
double magnetic_energy(const MagneticBody& on, const MagneticBody& by, double tolerance);
// The sum over all pairs whose carriers differ [J].
double magnetic_energy(const Team& team, const std::vector<MagneticBody>& bodies, double tolerance,
                       const std::vector<Index>& carrier = {});

}  // namespace loomstone
