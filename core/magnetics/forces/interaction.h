// Forces and torques between bodies. In general, the force that the field of one body exerts on the
// charge or current of the other is integrated. The reaction on the body that causes the field
// follows from the balance of linear and angular momentum, which therefore holds up to rounding
// errors.
//
// Dipoles, cells (see cells.h) and hard spheres need no integral, and pairs of parallel cuboids
// have a closed form. Integrals over an induced body are sums over samples of its charge; for pairs
// of induced bodies, see also panel_wrench.h. Integrals over other bodies are adaptive; see
// panel_quadrature.h. Bodies that overlap slightly, as rigid bodies in contact do, attract or repel
// each other as if they touched; overlap.h finds overlaps.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

struct Wrench {
  Vec3 force = Vec3::Zero();   // force [N]
  Vec3 torque = Vec3::Zero();  // torque about the centre of the body [N m]
  // Estimated error of the force and of torque / radius [N], due to adaptive integration or, for
  // parallel cuboids, to rounding. For the radius, see magnetic_wrench(). The error of induced
  // charge is not included; see charge_error.h.
  double error = 0.0;
};

// Returns the wrench on `on` exerted by `by`. The estimated error of an adaptive integral is at
// most `tolerance` times the largest of the force, torque / radius and `least` [N]; for exceptions,
// see integrate_panels(). The radius is that of the body whose charge or current is integrated.
// Throws InvalidInput if `tolerance` is not in [1e-12, 0.1] or a body is an open polyline.
Wrench magnetic_wrench(const MagneticBody& on, const MagneticBody& by, double tolerance,
                       double least = 0.0);

// Precomputed field of a body and its gradient at given points.
struct KnownField {
  MagneticBody body;
  Points points;           // (n x 3) [m]
  FieldAndGradient there;  // field and gradient at the points, in world axes
};

// Returns the wrench on every body exerted by all others. With the same exceptions as for
// magnetic_wrench(), the estimated error of each pair is at most `tolerance` times the largest of
// these: the pair's own force and torque / radius, and all forces known after a rough first pass.
// Bodies with a single dipole, such as hard spheres, interact by one direct sum. The forces between
// them and any other body follow from the field of the other body at all these dipoles. Results do
// not depend on the number of threads or on `known`, whose fields are not computed again. `carrier`
// (optional) contains, for each body, the index of the rigid body that carries it. Forces between
// bodies on one carrier are omitted, except those between single dipoles, which cancel in the
// carrier's total.
std::vector<Wrench> magnetic_wrenches(const Team& team, const std::vector<MagneticBody>& bodies,
                                      double tolerance, const std::vector<Index>& carrier = {},
                                      const std::vector<KnownField>& known = {});

// Returns the interaction energy [J] of two bodies at constant magnetisation. `tolerance` is that
// of integrate_panels(). Throws Unsupported if a body is a current, or if both bodies are induced,
// and InvalidInput if `tolerance` is not in [1e-12, 0.1].
double magnetic_energy(const MagneticBody& on, const MagneticBody& by, double tolerance);
// Returns the sum of the energies of all pairs of bodies on different carriers, or of all pairs if
// `carrier` is empty [J].
double magnetic_energy(const Team& team, const std::vector<MagneticBody>& bodies, double tolerance,
                       const std::vector<Index>& carrier = {});

}  // namespace loomstone
