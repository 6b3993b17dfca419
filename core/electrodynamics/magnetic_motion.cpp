#include "core/electrodynamics/magnetic_motion.h"

#include <algorithm>
#include <cmath>

#include "core/electrodynamics/coil_currents.h"
#include "core/electrodynamics/kick_drift_kick.h"
#include "core/electrodynamics/shared_kicks.h"
#include "core/electrodynamics/work_error.h"
#include "core/magnetics/induction/flux_linkage.h"

namespace loomstone {

namespace {

// A sub-step is halved, if possible, while its relative_work_error() exceeds this value [1]. The
// spurious energy of magnets that snap together is then at most about this fraction of their
// kinetic energy.
constexpr double work_tolerance = 0.02;

// Returns the work [J] that scripted obstacles do in `duration` [s] against the magnetic forces on
// the magnets that they carry. Forces due to magnetisation by given currents are excluded.
double work_of_obstacles(double duration, const std::vector<Twist>& twists,
                         const Actions& actions) {
  const std::size_t n_bodies = actions.magnets.size() - twists.size();
  double work = 0.0;
  for (std::size_t o = 0; o < twists.size(); ++o) {
    Wrench wrench = actions.magnets[n_bodies + o];
    if (!actions.magnetised.empty()) {
      wrench.force -= actions.magnetised[n_bodies + o].force;
      wrench.torque -= actions.magnetised[n_bodies + o].torque;
    }
    work -= duration * (wrench.force.dot(twists[o].velocity) + wrench.torque.dot(twists[o].spin));
  }
  return work;
}

std::vector<CarrierMotion> carrier_motions(const MagneticModel& model, const MovingBodies& bodies,
                                           const std::vector<RigidPose>& obstacles,
                                           const std::vector<Twist>& twists) {
  std::vector<CarrierMotion> motions;
  for (Index b = 0; b < model.n_bodies(); ++b) {
    const Vec4 orientation = bodies.state.orientations.row(b).transpose();
    const Vec3 momentum = bodies.momenta.row(b).transpose();
    motions.push_back({bodies.state.positions.row(b).transpose(),
                       bodies.state.velocities.row(b).transpose(),
                       angular_velocity(model.bodies[b].rotor, orientation, momentum)});
  }
  for (std::size_t o = 0; o < twists.size(); ++o)
    motions.push_back({obstacles[o].position, twists[o].velocity, twists[o].spin});
  return motions;
}

BodyImpulses no_impulses(Index n_bodies) {
  return {Points::Zero(n_bodies, 3), Points::Zero(n_bodies, 3)};
}

// Copies poses and velocities, but not RigidState::manifolds.
void put_back(const RigidState& from, RigidState& to) {
  to.positions = from.positions, to.orientations = from.orientations;
  to.velocities = from.velocities, to.angular_velocities = from.angular_velocities;
}

}  // namespace

MagneticMotion::MagneticMotion(const MagneticModel& model)
    : model_(model), magnets_(model), frequency_(model, magnets_), inductances_(model) {}

CarrierWrenches MagneticMotion::wrenches(const Team& team, const CarrierPlaces& places,
                                         const Vector& currents) const {
  const Magnetised magnetised = magnets_.at(team, places, carrying_coils(model_, places, currents));
  CarrierWrenches result = magnets_.wrenches(team, places, magnetised);
  if (!model_.coils.empty()) {
    const PlacedCoils coils(model_, places, std::vector<Twist>(places.obstacles.size()));
    add_times(result, 1.0, coils.with_magnets(magnetised.magnets, currents));
    add_times(result, 1.0, coils.among_coils(currents));
  }
  result.resize(model_.n_bodies());
  return result;
}

double MagneticMotion::energy(const Team& team, const CarrierPlaces& places,
                              const Points& moments) const {
  const bool here = last_ && model_.coils.empty() &&
                    last_->cause.positions == places.bodies.positions &&
                    last_->cause.orientations == places.bodies.orientations &&
                    last_->cause.obstacles == places.obstacles;
  return magnets_.energy(team, here ? last_->magnetised : magnets_.at(team, places, {}, moments));
}

MagneticMotion::Cause MagneticMotion::cause_of(const Moment& moment) const {
  const RigidState& bodies = moment.places.bodies;
  Cause cause{bodies.positions,
              bodies.orientations,
              moment.places.obstacles,
              {},
              currents_at(model_, moment.time)};
  for (const Twist& twist : moment.twists) cause.resting.push_back(twist.rests());
  return cause;
}

const MagneticMotion::Instant& MagneticMotion::arrive(const Team& team, const Moment& moment,
                                                      Points& moments) {
  Cause cause = cause_of(moment);
  if (last_ && last_->cause == cause) return *last_;
  previous_ = std::move(last_);
  last_.reset();
  const CarrierPlaces& places = moment.places;
  const bool magnetises = !magnets_.induced().empty();
  std::vector<MagneticBody> carrying;
  if (magnetises) carrying = carrying_coils(model_, places, cause.given);
  Instant now{std::move(cause), magnets_.at(team, places, carrying, moments), {}};
  Actions& actions = now.actions;
  moments = now.magnetised.moments;
  actions.magnets = magnets_.wrenches(team, places, now.magnetised);
  if (!carrying.empty()) {
    actions.magnetised = actions.magnets;
    add_times(actions.magnetised, -1.0,
              magnets_.wrenches(team, places, magnets_.at(team, places, {})));
  }
  const PlacedCoils coils(model_, places, moment.twists);
  CircuitResponse response;
  if (magnetises && !model_.circuits.empty()) response = this->response(team, moment, coils, now);
  actions.coils = coils.per_ampere(now.magnetised.magnets, moment.time, response);
  actions.inductances = inductances_.at(coils.with_one_ampere(), response);
  last_ = std::move(now);
  return *last_;
}

CircuitResponse MagneticMotion::response(const Team& team, const Moment& moment,
                                         const PlacedCoils& coils, const Instant& idle) const {
  const CarrierPlaces& places = moment.places;
  const auto trial = [&](const Vector& amperes) {
    const Vector currents = currents_at(model_, moment.time, amperes);
    const Magnetised then = magnets_.at(team, places, carrying_coils(model_, places, currents));
    CircuitTrial result{magnets_.wrenches(team, places, then), Vector::Zero(currents.size())};
    add_times(result.wrenches, 1.0, coils.with_magnets(then.magnets, currents));
    for (std::size_t j = 0; j < model_.coils.size(); ++j) {
      if (!model_.coils[j].wants_flux()) continue;
      for (const Index i : magnets_.induced())
        result.flux[static_cast<Eigen::Index>(j)] +=
            linked_flux(coils.with_one_ampere()[j], then.magnets[i]);
    }
    return result;
  };
  CarrierWrenches without = idle.actions.magnets;
  add_times(without, 1.0, coils.with_magnets(idle.magnetised.magnets, idle.cause.given));
  return circuit_response(model_.circuits, probe_currents(idle.magnetised.magnets), without, trial);
}

// Returns probe currents (circuits) [A] that give each circuit the dipole moment of the strongest
// magnet, so that their effect is comparable to that of the magnets. If no magnet has a moment, the
// probe currents are 1 A.
Vector MagneticMotion::probe_currents(const std::vector<MagneticBody>& magnets) const {
  double moment = 0.0;
  for (const MagneticBody& magnet : magnets)
    moment = std::max(moment, magnet.source->moment().norm());
  Vector amperes(model_.circuits.size());
  for (Eigen::Index k = 0; k < amperes.size(); ++k)
    amperes[k] =
        moment > 0.0 ? moment / model_.coils[model_.circuits[k]].source->moment().norm() : 1.0;
  return amperes;
}

double MagneticMotion::frequency(const Team& team, const CarrierPlaces& places,
                                 const Vector& currents, const Instant& now,
                                 const RigidWorld& world) const {
  const std::vector<MagneticBody>* magnets = &now.magnetised.magnets;
  Magnetised by_circuits;
  if (!magnets_.induced().empty() && !model_.circuits.empty()) {  // circuits also magnetise bodies
    by_circuits = magnets_.at(team, places, carrying_coils(model_, places, currents));
    magnets = &by_circuits.magnets;
  }
  return frequency_.at(team, {places, *magnets, now.magnetised.known, currents, world.touching()});
}

// A step in progress, which advances sub-step by sub-step.
struct MagneticMotion::Course {
  MagneticMotion& motion;
  const Team& team;
  const MagneticStep& step;
  RigidWorld& world;
  MagneticState& magnetic;
  std::vector<Twist> twists;
  MovingBodies bodies;
  BodyImpulses none;  // zero

  ObstaclePlaces obstacles_at(double share) const {
    return between(step.obstacles, step.moved_obstacles, share);
  }
  const Instant& arrive(const ObstaclePlaces& obstacles, double time) const {
    return motion.arrive(team, {{bodies.state, obstacles.poses}, twists, time}, magnetic.moments);
  }
  // Motion of bodies and obstacles at an instant.
  std::vector<CarrierMotion> motions(const ObstaclePlaces& obstacles) const {
    return carrier_motions(motion.model_, bodies, obstacles.poses, twists);
  }
  CarrierWrenches kick(double time, double duration, const Instant& now) const {
    return kick_wrenches(motion.model_,
                         {time, duration, bodies.state, bodies.momenta, twists, now.actions},
                         magnetic.circuits);
  }
  SubstepResult advance(const Substeps& parts);
};

// Advances bodies, circuits and induced moments by one sub-step. On entry, `last_` must be the
// instant at the start of the sub-step; on return, it is the instant at the end.
MagneticMotion::SubstepResult MagneticMotion::Course::advance(const Substeps& parts) {
  const MagneticModel& model = motion.model_;
  const double start = step.start + parts.elapsed(), h = parts.length();
  const ObstaclePlaces there = obstacles_at(parts.next_share());
  SubstepResult result;
  motion.previous_.reset();
  const CarrierWrenches between_first = wrenches_between_magnets(motion.last_->actions);
  const CarrierWrenches first = kick(start + 0.25 * h, 0.5 * h, *motion.last_);
  result.obstacle_work = work_of_obstacles(0.5 * h, twists, motion.last_->actions);
  const ContactAnswer answer = answer_contacts(
      model, h, first,
      {parts.first() ? step.at_start : none, parts.last() ? step.at_end : none, there}, bodies,
      world);
  result.obstacle_work += world.obstacle_work();
  const RigidState before = bodies.state;
  const double kinetic = kinetic_energy(model, bodies);
  half_kick(model, h, first, bodies);
  drift(model, h, first, answer, bodies);
  const Instant& now = arrive(there, start + h);
  result.obstacle_work += work_of_obstacles(0.5 * h, twists, now.actions);
  const CarrierWrenches second = kick(start + 0.75 * h, 0.5 * h, now);
  half_kick(model, h, second, bodies);
  share_kicks(model, {h, before, first, second, answer}, bodies);
  const SubstepWork work{before,
                         bodies.state,
                         answer.touched,
                         twists,
                         h,
                         between_first,
                         wrenches_between_magnets(now.actions)};
  result.error = relative_work_error(model, work, std::max(kinetic, kinetic_energy(model, bodies)));
  if (parts.last()) end_impulses(model, step.at_end, answer, bodies);
  return result;
}

MagneticEffort MagneticMotion::advance(const Team& team, const MagneticStep& step,
                                       RigidWorld& world, RigidState& state,
                                       MagneticState& magnetic) {
  Course course{*this,
                team,
                step,
                world,
                magnetic,
                obstacle_twists(step.obstacles.poses, step.moved_obstacles.poses, step.length),
                begin_motion(model_, step.at_start, state),
                no_impulses(model_.n_bodies())};
  MagneticEffort effort;
  course.arrive(step.obstacles, step.start);
  for (Substeps parts(step.length, model_.substep); parts.left(); ++effort.substeps) {
    const Vector currents = coil_currents(model_, magnetic.circuits, step.start + parts.elapsed());
    const ObstaclePlaces here = course.obstacles_at(parts.share());
    parts.resolve(frequency(team, {state, here.poses}, currents, *last_, world));
    parts.follow(frequency_.motion_rate(team, {state, here.poses}, course.motions(here),
                                        parts.resolved_motion()));
    Start start{state, course.bodies.momenta, magnetic};
    world.save(start.bodies);
    SubstepResult result = course.advance(parts);
    while (result.error > work_tolerance && parts.halve()) {
      world.restore(start.bodies);
      put_back(start.bodies, state);
      course.bodies.momenta = start.momenta, magnetic = start.magnetic;
      if (previous_) last_ = std::move(previous_);
      ++effort.substeps;
      result = course.advance(parts);
    }
    parts.pass();
    effort.obstacle_work += result.obstacle_work;
  }
  end_motion(model_, course.bodies);
  for (Index b = 0; b < model_.n_bodies(); ++b)
    effort.error = std::max(effort.error, last_->actions.magnets[b].error);
  return effort;
}

}  // namespace loomstone
