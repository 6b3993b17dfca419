// Error of the work done in the half kicks of a sub-step by two kinds of forces: those between
// magnets, and those of the uniform field on magnets. The work of currents is exact, because
// circuits lose the same energy (kick.h).
//
// Forces that grow as bodies approach each other do too much work in a sub-step, which appears as
// spurious energy when the bodies meet. There are two causes. Let F0 and F1 be the forces at the
// start and at the end of the sub-step, and W0 and W1 the work that each of them would do if it
// were constant along the whole displacement.
//
// The half kicks integrate the force along the displacement by the trapezoidal rule. A force that
// changes by a constant factor per length does the work (W1 - W0) / log(W1 / W0). The rule gives
// work of larger magnitude. To leading order, the difference is (W1 - W0)^2 / (6 |W0 + W1|).
//
// A free body of mass m and initial velocity v is displaced by h (v + h F0 / 2m) in the time h, but
// the mean of its initial and final velocities is v + h (F0 + F1) / 4m. Its kinetic energy grows by
// h times the mean force times this mean velocity. This growth exceeds the mean force times the
// displacement by h^2 (F1^2 - F0^2) / 8m.
//
// Only forces that grow along their own direction count: W0 < W1 with equal signs. This condition
// is the same for motion backwards in time. Errors of forces that drive a body back to an
// equilibrium cancel in the course of an oscillation.
#pragma once

#include <cstdint>
#include <vector>

#include "core/electrodynamics/carriers.h"
#include "core/electrodynamics/kick.h"
#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

// The displacements in a sub-step, and the wrenches_between_magnets() at its start and end.
struct SubstepWork {
  const RigidState &start, &end;
  const std::vector<std::uint8_t>& touched;  // (bodies) 1: body did not move freely
  const std::vector<Twist>& twists;          // motion of the obstacles
  double length;                             // [s]
  const CarrierWrenches first, second;
};

// Returns the wrenches on magnets due to each other and to the uniform field, without the part that
// is due to currents.
CarrierWrenches wrenches_between_magnets(const Actions& actions);

// Returns the error of the work divided by the sum of the absolute work and a tenth of `kinetic`,
// the kinetic energy of the bodies [J]. Error and absolute work are sums over bodies and obstacles.
double relative_work_error(const MagneticModel& model, const SubstepWork& work, double kinetic);

}  // namespace loomstone
