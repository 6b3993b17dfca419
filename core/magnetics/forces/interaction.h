// Forces and torques between bodies. In general, the charge or current of one body is integrated in
// the field of the other. The reaction on the other body follows from the balance of linear and
// angular momentum, which therefore holds up to rounding errors.
//
// Dipoles, cells and hard spheres need no integral, and parallel cuboids have a closed form.
// Induced bodies are integrated over samples of their charge, and other bodies over their panels.
// Bodies that overlap slightly, as rigid bodies in contact do, attract or repel each other as if
// they touched; overlap.h finds overlaps.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

struct Wrench {
  Vec3 force = Vec3::Zero();   // force [N]
  Vec3 torque = Vec3::Zero();  // torque about the centre of the body [N m]
  // Estimated error of the force and of torque / radius due to integration [N]; see also
  // charge_error.h.
  double error = 0.0;
};

// Returns the wrench on `on` exerted by `by`. The estimated error of an adaptive integral is at
// most `tolerance` times the largest of the force, torque / radius and `least` [N]; for exceptions,
// see integrate_panels(). The radius is that of the body whose charge or current is integrated.
Wrench magnetic_wrench(const MagneticBody& on, const MagneticBody& by, double tolerance,
                       double least = 0.0);

// Precomputed field of a body and its gradient at given points.
struct KnownField {
  MagneticBody body;
  Points points;           // (n x 3) [m]
  FieldAndGradient there;  // field and gradient at the points, in world axes
};

// Returns the wrench on every body exerted by all others. With the same exceptions as for
// magnetic_wrench(), the estimated error of each pair is at most `tolerance` times the largest
// force that a rough first pass finds, or times the pair's own force or torque / radius if that is
// larger. Single dipoles, which include hard spheres, interact by one direct sum. The forces
// between them and another body follow from the field of that body at all single dipoles. Results
// do not depend on the number of threads or on `known`, whose fields are not computed again.
// `carrier` (optional) is the index of the rigid body that carries each magnet. Forces between
// magnets on one carrier are omitted, except those between single dipoles, which cancel in the
// carrier's total.
std::vector<Wrench> magnetic_wrenches(const Team& team, const std::vector<MagneticBody>& bodies,
                                      double tolerance, const std::vector<Index>& carrier = {},
                                      const std::vector<KnownField>& known = {});

// Returns the interaction energy [J] of two bodies at constant magnetisation. It is defined for
// solid magnets and dipoles only. At most one of the bodies may be induced.
double magnetic_energy(const MagneticBody& on, const MagneticBody& by, double tolerance);
// Returns the sum of the energies of all pairs with different carriers [J].
double magnetic_energy(const Team& team, const std::vector<MagneticBody>& bodies, double tolerance,
                       const std::vector<Index>& carrier = {});

}  // namespace loomstone
