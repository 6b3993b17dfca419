#include "core/sim/currents.h"

#include <algorithm>
#include <cmath>

#include "core/magnetics/constants.h"
#include "core/sim/keyframes.h"
#include "core/sim/motion.h"

namespace loomstone {

namespace {

// Linear between times, constant beyond them; no values: 0.
double at_time(const std::vector<double>& times, const std::vector<double>& values, double time) {
  if (values.empty()) return 0.0;
  if (times.empty()) return values.front();
  const Keyframes at = keyframes_at(times, time);
  return values[at.first] + at.fraction * (values[at.second] - values[at.first]);
}

// Force that two dipoles feel at the distance of the bodies, or of their size: below a hundredth of it nothing matters.
double scale_of_force(const MagneticBody& a, const MagneticBody& b) {
  const double apart = std::max({(a.pose.position - b.pose.position).norm(), a.source->radius(), b.source->radius()});
  return 1.5 * mu0 / pi * a.source->moment().norm() * b.source->moment().norm() / std::pow(apart, 4);
}

}  // namespace

Currents::Currents(const Model& model, const std::vector<Rotor>& rotors) : model_(model), rotors_(rotors) {
  for (std::size_t j = 0; j < model.coils.size(); ++j)
    if (model.scene.coils[j].resistance == 0.0) order_.push_back(j);
  for (std::size_t j = 0; j < model.coils.size(); ++j)
    if (model.scene.coils[j].resistance > 0.0) order_.push_back(j);
}

void Currents::place(const RigidState& state, const std::vector<RigidPose>& obstacles,
                     const std::vector<MagneticBody>& magnets, const std::vector<Index>& groups, double time) {
  const Index n = model_.n_bodies();
  per_ampere_.assign(model_.coils.size(), std::vector<Wrench>(n));
  sense_.assign(model_.coils.size(), 1.0);
  std::vector<MagneticBody> coils;
  for (const Model::Wound& wound : model_.coils)
    coils.push_back({wound.source, carried_pose(state, obstacles, wound.carrier, wound.local)});
  for (std::size_t place = 0; place < order_.size(); ++place) {
    const std::size_t j = order_[place];
    const MagneticBody& coil = coils[j];
    const Index group = std::min(model_.coils[j].carrier, n);
    std::vector<Wrench>& result = per_ampere_[j];
    const auto add = [&](Index carrier, const Vec3& at, const Vec3& force, const Vec3& torque) {
      if (carrier >= n) return;
      result[carrier].force += force;
      result[carrier].torque += torque + (at - state.positions.row(carrier).transpose()).cross(force);
    };
    const auto meet = [&](const MagneticBody& other, Index carrier, double factor) {
      if (std::min(carrier, n) == group) return;
      const Wrench w =
          magnetic_wrench(coil, other, model_.scene.magnetic_tolerance, 0.1 * scale_of_force(coil, other));
      const Vec3 &here = coil.pose.position, &there = other.pose.position;
      add(group, here, factor * w.force, factor * w.torque);
      add(std::min(carrier, n), there, -factor * w.force, -factor * (w.torque + (here - there).cross(w.force)));
    };
    for (std::size_t k = 0; k < magnets.size(); ++k) meet(magnets[k], groups[k], 1.0);
    for (std::size_t before = 0; before < place; ++before) {  // all of them have given currents
      const Coil& given = model_.scene.coils[order_[before]];
      meet(coils[order_[before]], model_.coils[order_[before]].carrier, at_time(given.times, given.currents, time));
    }
    add(group, coil.pose.position, Vec3::Zero(), coil.moment().cross(model_.scene.magnetic_field));
    const Vec3 axis = rotation_matrix(coil.pose.orientation).col(2);
    if (axis.dot(model_.scene.coils[j].commutator) < 0.0) sense_[j] = -1.0;
  }
}

Currents::Twist Currents::middle(Index body, double duration, const RigidState& state, const Points& momenta,
                                 const Wrench& wrench) const {
  const Vec3 momentum = momenta.row(body).transpose();
  const Vec4 orientation = state.orientations.row(body).transpose();
  if (!held(body)) {
    const Vec3 start = state.velocities.row(body).transpose();
    return {start + 0.5 * duration * (wrench.force / model_.body_mass[body].mass + model_.scene.gravity),
            angular_velocity(rotors_[body], orientation, momentum + 0.5 * duration * wrench.torque)};
  }
  const Bearing& bearing = model_.scene.bearings[model_.bearing_of_body[body]];
  const Vec3 along = axis(body);
  const double inertia = along.dot(world_inertia(model_.body_mass[body], orientation) * along);
  const double torque = along.dot(wrench.torque) + bearing.torque;
  return {Vec3::Zero(), (along.dot(momentum) + 0.5 * duration * torque) / (inertia + 0.5 * duration * bearing.friction) * along};
}

double Currents::power(const std::vector<Wrench>& per_ampere, double duration, const RigidState& state,
                       const Points& momenta, const std::vector<Wrench>& wrenches) const {
  double sum = 0.0;
  for (Index b = 0; b < model_.n_bodies(); ++b) {
    const Twist twist = middle(b, duration, state, momenta, wrenches[b]);
    sum += per_ampere[b].force.dot(twist.velocity) + per_ampere[b].torque.dot(twist.spin);
  }
  return sum;
}

void Currents::kick(double time, double duration, const RigidState& state, const Points& momenta,
                    std::vector<Wrench>& wrenches, CircuitState& circuit) const {
  const auto add = [&](std::vector<Wrench>& to, std::size_t j, double current) {
    for (std::size_t b = 0; b < to.size(); ++b) {
      to[b].force += current * per_ampere_[j][b].force;
      to[b].torque += current * per_ampere_[j][b].torque;
    }
  };
  for (const std::size_t j : order_) {
    const Coil& coil = model_.scene.coils[j];
    if (coil.resistance == 0.0) add(wrenches, j, at_time(coil.times, coil.currents, time));
  }
  for (const std::size_t j : order_) {
    const Coil& coil = model_.scene.coils[j];
    if (coil.resistance == 0.0) continue;
    std::vector<Wrench> more = wrenches;
    add(more, j, 1.0);
    // What the bodies move without the current, and what one ampere adds to that.
    const double idle = power(per_ampere_[j], duration, state, momenta, wrenches);
    const double slope = power(per_ampere_[j], duration, state, momenta, more) - idle;
    const double voltage = sense_[j] * at_time(coil.times, coil.voltages, time), store = 2.0 * coil.inductance / duration;
    const double middle_current = (store * circuit.current + voltage - idle) / (store + coil.resistance + slope);
    add(wrenches, j, middle_current);
    circuit.current = coil.inductance > 0.0 ? 2.0 * middle_current - circuit.current : middle_current;
    circuit.heat += duration * coil.resistance * middle_current * middle_current;
    circuit.supply += duration * voltage * middle_current;
  }
  for (const std::size_t j : order_) {  // sources that hold a given current do what work is done
    const Coil& coil = model_.scene.coils[j];
    if (coil.resistance == 0.0)
      circuit.supply += duration * at_time(coil.times, coil.currents, time) *
                        power(per_ampere_[j], duration, state, momenta, wrenches);
  }
  for (Index b = 0; b < model_.n_bodies(); ++b) {
    if (!held(b)) continue;
    const Bearing& bearing = model_.scene.bearings[model_.bearing_of_body[b]];
    const Vec3 along = axis(b);
    const double spin = along.dot(middle(b, duration, state, momenta, wrenches[b]).spin);
    const double own = bearing.torque - bearing.friction * spin;
    wrenches[b].force = -model_.body_mass[b].mass * model_.scene.gravity;
    wrenches[b].torque = (along.dot(wrenches[b].torque) + own) * along;
    circuit.bearings -= duration * own * spin;
  }
}

}  // namespace loomstone
