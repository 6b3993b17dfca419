// Forces and torques between bodies. One body's charge or current is integrated in the exact field of the other; what
// the other feels follows from the balance of linear and angular momentum, which is therefore kept to rounding.
//
// Dipoles and spheres need no integral. Else panels are integrated by tensor Gauss rules and halved, in the direction
// that needs it, until the estimated error is below the tolerance; the estimate of a panel and direction is the square
// of the last Legendre coefficients over the largest, as the error of an n-point rule is a coefficient of degree 2 n.
//
// Bodies that overlap feel the forces between their surface charges, which are finite.
#pragma once

#include "core/magnetics/body.h"

namespace loomstone {

struct Wrench {
  Vec3 force = Vec3::Zero();   // [N]
  Vec3 torque = Vec3::Zero();  // about the body's own centre [N m]
  double error = 0.0;          // estimated, of the force and of torque / radius [N]
};

// Most evaluations of a field for one pair; what is reached then is returned with its error.
inline constexpr Index most_evaluations = 2000000;

// On `on` by `by`, to `tolerance` times the larger of its force and of `least` [N]; torques count divided by the radius
// of the body that is integrated over.
Wrench magnetic_wrench(const MagneticBody& on, const MagneticBody& by, double tolerance, double least = 0.0);

// On every body by all others, each pair to `tolerance` times the largest force of a pair, or of what spheres feel from
// one another: these act by one sum over dipoles. Sums run over pairs in order.
std::vector<Wrench> magnetic_wrenches(const Team& team, const std::vector<MagneticBody>& bodies, double tolerance);

}  // namespace loomstone
