#include "core/electrodynamics/magnetic_motion.h"

#include <algorithm>
#include <cmath>

#include "core/electrodynamics/coil_currents.h"
#include "core/electrodynamics/kick_drift_kick.h"
#include "core/magnetics/induction/flux_linkage.h"

namespace loomstone {

namespace {

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
// magnet, so that their effect is comparable to that of the magnets.
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

MagneticEffort MagneticMotion::advance(const Team& team, const MagneticStep& step,
                                       RigidWorld& world, RigidState& state,
                                       MagneticState& magnetic) {
  const std::vector<Twist> twists =
      obstacle_twists(step.obstacles.poses, step.moved_obstacles.poses, step.length);
  const auto obstacles_at = [&](double share) {
    return between(step.obstacles, step.moved_obstacles, share);
  };
  const auto arrive_at = [&](const ObstaclePlaces& obstacles, double time) -> const Instant& {
    return arrive(team, {{state, obstacles.poses}, twists, time}, magnetic.moments);
  };
  MovingBodies bodies = begin_motion(model_, step.impulses, step.angular_impulses, state);
  const auto kick = [&](double time, double duration, const Instant& now) {
    return kick_wrenches(model_, {time, duration, state, bodies.momenta, twists, now.actions},
                         magnetic.circuits);
  };
  MagneticEffort effort;
  const Instant* now = &arrive_at(step.obstacles, step.start);
  for (Substeps parts(step.length, model_.substep); parts.left(); ++effort.substeps) {
    const double start = step.start + parts.elapsed();
    const Vector currents = coil_currents(model_, magnetic.circuits, start);
    const ObstaclePlaces here = obstacles_at(parts.share());
    parts.resolve(frequency(team, {state, here.poses}, currents, *now, world));
    const double h = parts.length();
    parts.pass();
    const ObstaclePlaces there = obstacles_at(parts.share());

    CarrierWrenches wrenches = kick(start + 0.25 * h, 0.5 * h, *now);
    const ContactAnswer answer = answer_contacts(model_, h, wrenches, there, bodies, world);
    half_kick(model_, h, wrenches, bodies);
    drift(model_, h, wrenches, answer, bodies);
    effort.obstacle_work +=
        world.obstacle_work() + work_of_obstacles(0.5 * h, twists, now->actions);
    now = &arrive_at(there, start + h);
    effort.obstacle_work += work_of_obstacles(0.5 * h, twists, now->actions);
    wrenches = kick(start + 0.75 * h, 0.5 * h, *now);
    half_kick(model_, h, wrenches, bodies);
  }
  end_motion(model_, bodies);
  for (Index b = 0; b < model_.n_bodies(); ++b)
    effort.error = std::max(effort.error, now->actions.magnets[b].error);
  return effort;
}

}  // namespace loomstone
