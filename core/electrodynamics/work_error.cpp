#include "core/electrodynamics/work_error.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

namespace {

// Fraction of the kinetic energy that is added to the absolute work in the divisor of the relative
// error [1]. The relative error thus stays bounded if there is little work.
constexpr double least_work = 0.1;

double work_along(const Wrench& wrench, const Twist& displacement) {
  return wrench.force.dot(displacement.velocity) + wrench.torque.dot(displacement.spin);
}

// Returns the displacement [m] and rotation vector [rad] of a carrier in the sub-step. If no torque
// acts on a body, its rotation does not contribute to the work and is returned as zero.
Twist displacement(const SubstepWork& work, Index carrier) {
  const auto n = static_cast<Index>(work.start.positions.rows());
  if (carrier >= n) {
    const Twist& twist = work.twists[carrier - n];
    return {work.length * twist.velocity, work.length * twist.spin};
  }
  Twist moved;
  moved.velocity =
      (work.end.positions.row(carrier) - work.start.positions.row(carrier)).transpose();
  if (!work.first[carrier].torque.isZero(0.0) || !work.second[carrier].torque.isZero(0.0))
    moved.spin = angular_velocity_between(work.start.orientations.row(carrier).transpose(),
                                          work.end.orientations.row(carrier).transpose(), 1.0);
  return moved;
}

// Returns the square of a wrench in the metric of the body's inverse inertia: twice the kinetic
// energy that it gives to the body at rest, per squared duration [J/s^2]. If the body is in a
// bearing, only the torque about its axis counts.
double squared(const MagneticRotor& body, const Vec4& orientation, const Wrench& wrench) {
  if (body.bearing) {
    const Vec3 along = wrench.torque.dot(body.bearing->axis) * body.bearing->axis;
    return along.dot(angular_velocity(body.rotor, orientation, along));
  }
  return wrench.force.squaredNorm() / body.mass.mass +
         wrench.torque.dot(angular_velocity(body.rotor, orientation, wrench.torque));
}

}  // namespace

CarrierWrenches wrenches_between_magnets(const Actions& actions) {
  CarrierWrenches wrenches = actions.magnets;
  if (!actions.magnetised.empty()) add_times(wrenches, -1.0, actions.magnetised);
  return wrenches;
}

double relative_work_error(const MagneticModel& model, const SubstepWork& work, double kinetic) {
  double error = 0.0, done = least_work * kinetic;
  for (std::size_t c = 0; c < work.first.size(); ++c) {
    const auto carrier = static_cast<Index>(c);
    const Twist moved = displacement(work, carrier);
    const Wrench &first = work.first[c], &second = work.second[c];
    const double w0 = work_along(first, moved), w1 = work_along(second, moved);
    done += 0.5 * std::abs(w0 + w1);
    if (!(w0 < w1 && w0 * w1 > 0.0)) continue;
    error += (w1 - w0) * (w1 - w0) / (6.0 * std::abs(w0 + w1));
    if (carrier >= model.n_bodies() || work.touched[c]) continue;
    const Vec4 orientation = work.end.orientations.row(carrier).transpose();
    error += 0.125 * work.length * work.length *
             std::abs(squared(model.bodies[c], orientation, second) -
                      squared(model.bodies[c], orientation, first));
  }
  return error > 0.0 ? error / done : 0.0;
}

}  // namespace loomstone
