#include "core/electrodynamics/kick_drift_kick.h"

#include <cmath>

#include "core/base/message.h"

namespace loomstone {

namespace {

// Largest number of sub-steps per step. If more are needed, magnets overlap or the step is far too
// long.
constexpr int most_substeps = 4096;
// After its first call, resolve() halves sub-steps only if length times frequency exceeds this
// multiple of the limit.
constexpr double tolerated_growth = 4.0 / 3.0;

// Removes all motion that the bearing of the body, if any, does not permit.
template <class Velocity, class Momentum>
void guide(const MagneticRotor& body, Velocity&& velocity, Momentum&& momentum) {
  if (!body.bearing) return;
  const Vec3& axis = body.bearing->axis;
  momentum = momentum.dot(axis) * axis.transpose();
  velocity.setZero();
}

void push(const MagneticRotor& body, Index b, const BodyImpulses& impulses, MovingBodies& bodies) {
  bodies.state.velocities.row(b) += impulses.linear.row(b) / body.mass.mass;
  bodies.momenta.row(b) += impulses.angular.row(b);
  guide(body, bodies.state.velocities.row(b), bodies.momenta.row(b));
}

}  // namespace

void Substeps::resolve(double frequency) {
  while (frequency * step_ > limit_ * parts_ && parts_ <= most_substeps) parts_ *= 2, place_ *= 2;
  if (parts_ > most_substeps || !std::isfinite(frequency)) {
    fail<SolverFailure>(
        "magnets and coils must move in at most {} sub-steps per step, got an angular frequency of "
        "{:.6g} "
        "rad/s at a step of {:.6g} s; shorten integrator.step, or keep point dipoles apart",
        most_substeps, frequency, step_);
  }
  limit_ = tolerated_growth * most_;
}

void Substeps::follow(double motion_rate) {
  while (motion_rate > resolved_motion() && halve()) continue;
}

bool Substeps::halve() {
  if (2 * parts_ > most_substeps) return false;
  parts_ *= 2, place_ *= 2;
  return true;
}

MovingBodies begin_motion(const MagneticModel& model, const BodyImpulses& impulses,
                          RigidState& state) {
  MovingBodies bodies{state, Points(model.n_bodies(), 3)};
  for (Index b = 0; b < model.n_bodies(); ++b) {
    const Vec3 spin = state.angular_velocities.row(b).transpose();
    bodies.momenta.row(b) =
        angular_momentum(model.bodies[b].rotor, state.orientations.row(b).transpose(), spin)
            .transpose();
    push(model.bodies[b], b, impulses, bodies);
  }
  return bodies;
}

void end_impulses(const MagneticModel& model, const BodyImpulses& impulses,
                  const ContactAnswer& answer, MovingBodies& bodies) {
  for (Index b = 0; b < model.n_bodies(); ++b)
    if (!answer.touched[b]) push(model.bodies[b], b, impulses, bodies);
}

ContactAnswer answer_contacts(const MagneticModel& model, double h, const CarrierWrenches& wrenches,
                              const SubstepConditions& inputs, const MovingBodies& bodies,
                              RigidWorld& world) {
  const RigidState& state = bodies.state;
  ContactAnswer answer{
      {state.positions, state.orientations, state.velocities, state.angular_velocities, {}},
      {},
      {},
      {bodies.momenta, bodies.momenta}};
  const BodyImpulses &start = inputs.at_start, &end = inputs.at_end;
  BodyImpulses all{Points(model.n_bodies(), 3), Points(model.n_bodies(), 3)}, half = all;
  for (Index b = 0; b < model.n_bodies(); ++b) {
    const MagneticRotor& body = model.bodies[b];
    half.linear.row(b) = 0.5 * h * (wrenches[b].force + body.mass.mass * model.gravity).transpose();
    half.angular.row(b) = 0.5 * h * wrenches[b].torque.transpose();
    all.linear.row(b) = 2.0 * half.linear.row(b) + start.linear.row(b) + end.linear.row(b);
    all.angular.row(b) = 2.0 * half.angular.row(b) + start.angular.row(b) + end.angular.row(b);
    answer.state.velocities.row(b) -= start.linear.row(b) / body.mass.mass;
    Eigen::RowVector3d momentum = bodies.momenta.row(b) - start.angular.row(b);
    guide(body, half.linear.row(b), half.angular.row(b));
    guide(body, all.linear.row(b), all.angular.row(b));
    guide(body, answer.state.velocities.row(b), momentum);
    answer.state.angular_velocities.row(b) =
        angular_velocity(body.rotor, state.orientations.row(b).transpose(), momentum.transpose())
            .transpose();
  }
  for (Index b = 0; b < model.n_bodies(); ++b) {
    answer.without.linear.row(b) =
        model.bodies[b].mass.mass * answer.state.velocities.row(b) + all.linear.row(b);
    answer.without.angular.row(b) += all.angular.row(b) - start.angular.row(b);
  }
  world.advance(h, all, inputs.end, answer.state, &answer.touched, &half);
  answer.groups = pressed_groups(model, world.pressed());
  return answer;
}

void half_kick(const MagneticModel& model, double h, const CarrierWrenches& wrenches,
               MovingBodies& bodies) {
  for (Index b = 0; b < model.n_bodies(); ++b) {
    bodies.momenta.row(b) += 0.5 * h * wrenches[b].torque.transpose();
    bodies.state.velocities.row(b) +=
        0.5 * h * (wrenches[b].force / model.bodies[b].mass.mass + model.gravity).transpose();
  }
}

void drift(const MagneticModel& model, double h, const CarrierWrenches& wrenches,
           const ContactAnswer& answer, MovingBodies& bodies) {
  RigidState& state = bodies.state;
  for (Index b = 0; b < model.n_bodies(); ++b) {
    const MagneticRotor& body = model.bodies[b];
    const Vec4 orientation = state.orientations.row(b).transpose();
    if (!answer.touched[b]) {
      state.positions.row(b) += h * state.velocities.row(b);
      state.orientations.row(b) =
          freely_turned(body.rotor, orientation, bodies.momenta.row(b).transpose(), h).transpose();
      continue;
    }
    const Vec3 spin = answer.state.angular_velocities.row(b).transpose();
    bodies.momenta.row(b) = angular_momentum(body.rotor, orientation, spin).transpose();
    bodies.momenta.row(b) -= 0.5 * h * wrenches[b].torque.transpose();
    state.velocities.row(b) =
        answer.state.velocities.row(b) -
        0.5 * h * (wrenches[b].force / body.mass.mass + model.gravity).transpose();
    state.positions.row(b) = answer.state.positions.row(b);
    state.orientations.row(b) = answer.state.orientations.row(b);
    guide(body, state.velocities.row(b), bodies.momenta.row(b));
  }
}

double kinetic_energy(const MagneticModel& model, const MovingBodies& bodies) {
  double energy = 0.0;
  for (Index b = 0; b < model.n_bodies(); ++b) {
    const Vec3 momentum = bodies.momenta.row(b).transpose();
    const Vec3 spin = angular_velocity(model.bodies[b].rotor,
                                       bodies.state.orientations.row(b).transpose(), momentum);
    energy += 0.5 * (model.bodies[b].mass.mass * bodies.state.velocities.row(b).squaredNorm() +
                     momentum.dot(spin));
  }
  return energy;
}

void end_motion(const MagneticModel& model, MovingBodies& bodies) {
  RigidState& state = bodies.state;
  for (Index b = 0; b < model.n_bodies(); ++b) {
    state.angular_velocities.row(b) =
        angular_velocity(model.bodies[b].rotor, state.orientations.row(b).transpose(),
                         bodies.momenta.row(b).transpose())
            .transpose();
    if (!state.positions.row(b).allFinite() || !state.velocities.row(b).allFinite() ||
        !bodies.momenta.row(b).allFinite())
      fail<SolverFailure>(
          "bodies[{}] must stay finite, got NaN or infinity from magnetic forces; shorten "
          "integrator.step",
          b);
  }
}

}  // namespace loomstone
