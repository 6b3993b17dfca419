#include "core/electrodynamics/currents.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/magnetics/induction/mutual_inductance.h"
#include "core/magnetics/sources/axisymmetric.h"
#include "core/magnetics/sources/constants.h"
#include "core/sim/model/motion.h"
#include "core/base/keyframes.h"

namespace loomstone {

namespace {

// What circuits do to one another as they move depends on their currents: so often these are taken
// anew in a kick, where the change falls by the share of a current that a kick changes.
constexpr int rounds = 4;

// Linear between times, constant beyond them; no values: 0.
double at_time(const std::vector<double>& times, const std::vector<double>& values, double time) {
  if (values.empty()) return 0.0;
  if (times.empty()) return values.front();
  const Keyframes at = keyframes_at(times, time);
  return values[at.first] + at.fraction * (values[at.second] - values[at.first]);
}

// Force that two dipoles feel at the distance of the bodies, or of their size: below a hundredth of
// it nothing matters.
double scale_of_force(const MagneticBody& a, const MagneticBody& b) {
  const double apart = std::max(
      {(a.pose.position - b.pose.position).norm(), a.source->radius(), b.source->radius()});
  return 1.5 * mu0 / pi * a.source->moment().norm() * b.source->moment().norm() /
         std::pow(apart, 4);
}

// Of a coil without a circuit [A].
double given_at(const Coil& coil, double time) { return at_time(coil.times, coil.currents, time); }

}  // namespace

bool wants_flux(const Coil& coil) { return coil.resistance > 0.0 || !coil.times.empty(); }

SourcePtr wound_source(const Coil& coil, double current) {
  if (coil.shape == "loop") return std::make_shared<Loop>(coil.radius, coil.turns * current);
  return std::make_shared<Solenoid>(coil.radius, coil.length, coil.turns, current);
}

Vector coil_currents(const Model& model, const State& state, double time) {
  Vector currents = state.circuits.currents;
  for (Index j = 0; j < static_cast<Index>(currents.size()); ++j) {
    const Coil& coil = model.scene.coils[j];
    if (coil.resistance == 0.0) currents[j] = given_at(coil, time);
  }
  return currents;
}

Points carrier_centres(const RigidState& state, const std::vector<RigidPose>& obstacles) {
  const Eigen::Index n = state.positions.rows();
  Points centres(n + static_cast<Eigen::Index>(obstacles.size()), 3);
  centres.topRows(n) = state.positions;
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    centres.row(n + static_cast<Eigen::Index>(i)) = obstacles[i].position.transpose();
  return centres;
}

std::vector<MagneticBody> carrying_coils(const Model& model, const RigidState& state,
                                         const std::vector<RigidPose>& obstacles,
                                         const Vector& currents) {
  std::vector<MagneticBody> coils;
  for (std::size_t j = 0; j < model.coils.size() && static_cast<Eigen::Index>(j) < currents.size();
       ++j) {
    const double current = currents[static_cast<Eigen::Index>(j)];
    if (current == 0.0) continue;
    const Model::Wound& wound = model.coils[j];
    coils.push_back({wound_source(model.scene.coils[j], current),
                     carried_pose(state, obstacles, wound.carrier, wound.local)});
  }
  return coils;
}

double first_circuit_current(const Model& model, const State& state) {
  for (std::size_t j = 0; j < model.coils.size(); ++j)
    if (model.scene.coils[j].resistance > 0.0)
      return state.circuits.currents[static_cast<Eigen::Index>(j)];
  return 0.0;
}

Currents::Currents(const Model& model, const std::vector<Rotor>& rotors)
    : model_(model), rotors_(rotors) {
  for (std::size_t j = 0; j < model.coils.size(); ++j)
    (model.scene.coils[j].resistance == 0.0 ? given_ : circuits_).push_back(j);
  scripted_.assign(model.obstacles.size(), {Vec3::Zero(), Vec3::Zero()});
}

double Currents::given_current(std::size_t coil, double time) const {
  return given_at(model_.scene.coils[coil], time);
}

Vector Currents::all(double time, const Vector& circuits) const {
  Vector currents = Vector::Zero(static_cast<Eigen::Index>(model_.coils.size()));
  for (const std::size_t j : given_)
    currents[static_cast<Eigen::Index>(j)] = given_current(j, time);
  for (Eigen::Index k = 0; k < circuits.size(); ++k)
    currents[static_cast<Eigen::Index>(circuits_[k])] = circuits[k];
  return currents;
}

void Currents::move(const std::vector<RigidPose>& from, const std::vector<RigidPose>& to,
                    double step) {
  for (std::size_t i = 0; i < scripted_.size(); ++i) {
    const Vec4 &start = from[i].orientation, &end = to[i].orientation;
    scripted_[i].velocity = (to[i].position - from[i].position) / step;
    scripted_[i].spin =
        start == end ? Vec3(Vec3::Zero()) : angular_velocity_between(start, end, step);
  }
}

std::vector<std::uint8_t> Currents::resting() const {
  std::vector<std::uint8_t> resting;
  for (const Twist& twist : scripted_) resting.push_back(twist.rests());
  return resting;
}

bool Currents::joined(Index a, Index b) const {
  const auto rests = [&](Index carrier) {
    return carrier >= model_.n_bodies() && scripted_[carrier - model_.n_bodies()].rests();
  };
  return a == b || (rests(a) && rests(b));
}

// Adds what a coil of one ampere and `other`, `factor` times, do to one another, about the centres
// of their carriers.
void Currents::meet(const Part& coil, const Part& other, double factor, const Points& centres,
                    Wrenches& result) const {
  if (joined(coil.carrier, other.carrier)) return;
  const Wrench w = magnetic_wrench(coil.body, other.body, model_.scene.magnetic_tolerance,
                                   0.1 * scale_of_force(coil.body, other.body));
  const auto add = [&](Index carrier, const Vec3& at, const Vec3& force, const Vec3& torque) {
    result[carrier].force += force;
    result[carrier].torque += torque + (at - centres.row(carrier).transpose()).cross(force);
  };
  const Vec3 &here = coil.body.pose.position, &there = other.body.pose.position;
  add(coil.carrier, here, factor * w.force, factor * w.torque);
  add(other.carrier, there, -factor * w.force,
      -factor * (w.torque + (here - there).cross(w.force)));
}

void Currents::place_inductances(const std::vector<MagneticBody>& coils,
                                 const CircuitResponse& response) {
  const auto mutual = [&](std::size_t j, std::size_t k) {
    const RigidPose pose = relative_pose(coils[k].pose, coils[j].pose);
    const auto known = known_.find({j, k});
    if (known != known_.end() && known->second.pose == pose) return known->second.value;
    const double tolerance = std::max(1e-2 * model_.scene.magnetic_tolerance, 1e-12);
    return (known_[{j, k}] = {pose, mutual_inductance(coils[j], coils[k], tolerance)}).value;
  };
  const auto m = static_cast<Eigen::Index>(circuits_.size());
  inductances_.resize(m, m);
  from_given_.resize(m, given_.size());
  for (Eigen::Index a = 0; a < m; ++a) {
    inductances_(a, a) = model_.scene.coils[circuits_[a]].inductance;
    for (Eigen::Index b = 0; b < a; ++b)
      inductances_(a, b) = inductances_(b, a) = mutual(circuits_[b], circuits_[a]);
    for (std::size_t g = 0; g < given_.size(); ++g)
      from_given_(a, g) =
          model_.scene.coils[given_[g]].times.empty() ? 0.0 : mutual(given_[g], circuits_[a]);
  }
  if (response.linear.empty()) return;
  for (Eigen::Index a = 0; a < m; ++a) {
    for (Eigen::Index b = 0; b < m; ++b)
      inductances_(a, b) += response.inductances(a, circuits_[b]);
    for (std::size_t g = 0; g < given_.size(); ++g)
      from_given_(a, g) += response.inductances(a, given_[g]);
    if (!(inductances_(a, a) > 0.0))
      throw InvalidInput("coils[" + std::to_string(circuits_[a]) +
                         "].inductance must be that of the winding in air, more than the " +
                         std::to_string(-response.inductances(a, circuits_[a])) +
                         " H that diamagnetic bodies in it take away, got " +
                         std::to_string(model_.scene.coils[circuits_[a]].inductance) + " H");
  }
}

std::vector<Wrench> Currents::on_coils(const RigidState& state,
                                       const std::vector<RigidPose>& obstacles,
                                       const Vector& currents) const {
  const Points centres = carrier_centres(state, obstacles);
  const std::vector<MagneticBody> coils = placed_coils(state, obstacles);
  Wrenches result(centres.rows());
  for (std::size_t j = 0; j < coils.size(); ++j) {
    const double current = currents[static_cast<Eigen::Index>(j)];
    result[model_.coils[j].carrier].torque +=
        current * coils[j].moment().cross(model_.scene.magnetic_field);
    for (std::size_t k = 0; k < j && current != 0.0; ++k)
      meet({coils[j], model_.coils[j].carrier}, {coils[k], model_.coils[k].carrier},
           current * currents[static_cast<Eigen::Index>(k)], centres, result);
  }
  return result;
}

std::vector<MagneticBody> Currents::placed_coils(const RigidState& state,
                                                 const std::vector<RigidPose>& obstacles) const {
  std::vector<MagneticBody> coils;
  for (const Model::Wound& wound : model_.coils)
    coils.push_back({wound.source, carried_pose(state, obstacles, wound.carrier, wound.local)});
  return coils;
}

std::vector<Wrench> Currents::on_magnets(const RigidState& state,
                                         const std::vector<RigidPose>& obstacles,
                                         const std::vector<MagneticBody>& magnets,
                                         const Vector& currents) const {
  const Points centres = carrier_centres(state, obstacles);
  const std::vector<MagneticBody> coils = placed_coils(state, obstacles);
  Wrenches result(centres.rows());
  for (std::size_t j = 0; j < coils.size(); ++j)
    for (std::size_t k = 0; k < magnets.size() && currents[static_cast<Eigen::Index>(j)] != 0.0;
         ++k)
      meet({coils[j], model_.coils[j].carrier}, {magnets[k], model_.magnets[k].carrier},
           currents[static_cast<Eigen::Index>(j)], centres, result);
  return result;
}

void Currents::place(const RigidState& state, const std::vector<RigidPose>& obstacles,
                     const std::vector<MagneticBody>& magnets, double time,
                     std::vector<Wrench> magnetised, const CircuitResponse& response) {
  const Points centres = carrier_centres(state, obstacles);
  const Index n_carriers = static_cast<Index>(centres.rows());
  magnetised_ = std::move(magnetised);
  per_ampere_.assign(model_.coils.size(), Wrenches(n_carriers));
  sense_.assign(model_.coils.size(), 1.0);
  const std::vector<MagneticBody> coils = placed_coils(state, obstacles);
  const auto part = [&](std::size_t j) { return Part{coils[j], model_.coils[j].carrier}; };
  const bool answered = !response.linear.empty();
  const auto place_coil = [&](std::size_t j, std::size_t n_given, bool on_magnets) {
    Wrenches& result = per_ampere_[j];
    for (std::size_t k = 0; k < magnets.size() && on_magnets; ++k)
      meet(part(j), {magnets[k], model_.magnets[k].carrier}, 1.0, centres, result);
    for (std::size_t g = 0; g < n_given; ++g)
      meet(part(j), part(given_[g]), given_current(given_[g], time), centres, result);
    result[model_.coils[j].carrier].torque += coils[j].moment().cross(model_.scene.magnetic_field);
    const Vec3 axis = rotation_matrix(coils[j].pose.orientation).col(2);
    if (axis.dot(model_.scene.coils[j].commutator) < 0.0) sense_[j] = -1.0;
  };
  for (std::size_t g = 0; g < given_.size(); ++g) place_coil(given_[g], g, true);
  for (std::size_t k = 0; k < circuits_.size(); ++k) {
    place_coil(circuits_[k], given_.size(), !answered);
    if (answered) add_times(per_ampere_[circuits_[k]], 1.0, response.linear[k]);
  }
  pairs_ = response.quadratic;
  for (std::size_t k = 1; k < circuits_.size(); ++k) {
    for (std::size_t j = 0; j < k; ++j) {
      const Part a = part(circuits_[j]), b = part(circuits_[k]);
      if (joined(a.carrier, b.carrier)) continue;
      pairs_.push_back({j, k, Wrenches(n_carriers)});
      meet(a, b, 1.0, centres, pairs_.back().wrenches);
    }
  }
  place_inductances(coils, response);
}

Currents::Twist Currents::middle(Index body, double duration, const RigidState& state,
                                 const Points& momenta, const Wrench& wrench) const {
  const Vec3 momentum = momenta.row(body).transpose();
  const Vec4 orientation = state.orientations.row(body).transpose();
  if (!held(body)) {
    const Vec3 start = state.velocities.row(body).transpose();
    return {
        start +
            0.5 * duration * (wrench.force / model_.body_mass[body].mass + model_.scene.gravity),
        angular_velocity(rotors_[body], orientation, momentum + 0.5 * duration * wrench.torque)};
  }
  const Bearing& bearing = model_.scene.bearings[model_.bearing_of_body[body]];
  const Vec3 along = axis(body);
  const double inertia = along.dot(world_inertia(model_.body_mass[body], orientation) * along);
  const double torque = along.dot(wrench.torque) + bearing.torque;
  return {Vec3::Zero(), (along.dot(momentum) + 0.5 * duration * torque) /
                            (inertia + 0.5 * duration * bearing.friction) * along};
}

double Currents::power(const Wrenches& per_ampere, double duration, const RigidState& state,
                       const Points& momenta, const Wrenches& wrenches) const {
  double sum = 0.0;
  for (Index b = 0; b < model_.n_bodies(); ++b) {
    const Twist twist = middle(b, duration, state, momenta, wrenches[b]);
    sum += per_ampere[b].force.dot(twist.velocity) + per_ampere[b].torque.dot(twist.spin);
  }
  return sum;
}

double Currents::scripted_power(const Wrenches& per_ampere) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < scripted_.size(); ++i) {
    const Wrench& wrench = per_ampere[model_.n_bodies() + i];
    sum += wrench.force.dot(scripted_[i].velocity) + wrench.torque.dot(scripted_[i].spin);
  }
  return sum;
}

// Middle currents i_m of (2 L / tau + R) (i_m) + E(i_m) = 2 L i / tau + V - M di_g / tau, with E
// the power per ampere, linear in the wrenches and so in i_m but for what circuits do to one
// another.
void Currents::advance_circuits(double time, double duration, const RigidState& state,
                                const Points& momenta, Wrenches& wrenches,
                                CircuitState& circuits) const {
  const auto m = static_cast<Eigen::Index>(circuits_.size());
  Vector before(m), voltages(m), induced = Vector::Zero(m);
  Eigen::MatrixXd fixed = 2.0 / duration * inductances_;
  Vector change(given_.size());
  for (std::size_t g = 0; g < given_.size(); ++g)
    change[g] = given_current(given_[g], time + 0.5 * duration) -
                given_current(given_[g], time - 0.5 * duration);
  if (!given_.empty()) induced = from_given_ * change;
  for (Eigen::Index a = 0; a < m; ++a) {
    const Coil& coil = model_.scene.coils[circuits_[a]];
    before[a] = circuits.currents[circuits_[a]];
    voltages[a] = sense_[circuits_[a]] * at_time(coil.times, coil.voltages, time);
    fixed(a, a) += coil.resistance;
  }
  const Vector stored = 2.0 / duration * (inductances_ * before);
  Vector middle_currents = before;
  std::vector<Wrenches> felt,
      exerted;  // per ampere of each circuit: what its EMF follows, and what bodies feel
  for (int round = 0; round < (pairs_.empty() ? 1 : rounds); ++round) {
    felt.clear();
    for (const std::size_t j : circuits_) felt.push_back(per_ampere_[j]);
    exerted = felt;
    const auto act = [&](std::size_t own, std::size_t other, const Wrenches& what) {
      add_times(felt[own], middle_currents[static_cast<Eigen::Index>(other)], what);
      add_times(exerted[own], 0.5 * middle_currents[static_cast<Eigen::Index>(other)], what);
    };
    for (const Pair& pair : pairs_) {
      act(pair.j, pair.k, pair.wrenches);
      if (pair.j != pair.k) act(pair.k, pair.j, pair.wrenches);
    }
    Eigen::MatrixXd matrix = fixed;
    Vector right = stored + voltages - induced / duration;
    std::vector<Wrenches> with(m, wrenches);
    for (Eigen::Index k = 0; k < m; ++k) add_times(with[k], 1.0, exerted[k]);
    for (Eigen::Index j = 0; j < m; ++j) {
      // What the bodies move without the currents, and what one ampere adds to that.
      const double idle = power(felt[j], duration, state, momenta, wrenches);
      right[j] -= idle + scripted_power(felt[j]);
      for (Eigen::Index k = 0; k < m; ++k)
        matrix(j, k) += power(felt[j], duration, state, momenta, with[k]) - idle;
    }
    middle_currents = matrix.partialPivLu().solve(right);
  }
  Vector after(m);
  for (Eigen::Index a = 0; a < m; ++a) {
    const Coil& coil = model_.scene.coils[circuits_[a]];
    add_times(wrenches, middle_currents[a], exerted[a]);
    after[a] = coil.inductance > 0.0 ? 2.0 * middle_currents[a] - before[a] : middle_currents[a];
    circuits.currents[circuits_[a]] = after[a];
    circuits.heat += duration * coil.resistance * middle_currents[a] * middle_currents[a];
    circuits.supply +=
        duration * voltages[a] * middle_currents[a] - induced[a] * middle_currents[a];
    circuits.supply -= duration * middle_currents[a] * scripted_power(exerted[a]);
  }
  circuits.energy = 0.5 * (inductances_ * after).dot(after);
}

void Currents::kick(double time, double duration, const RigidState& state, const Points& momenta,
                    std::vector<Wrench>& wrenches, CircuitState& circuits) {
  for (const std::size_t j : given_) add_times(wrenches, given_current(j, time), per_ampere_[j]);
  if (!circuits_.empty()) advance_circuits(time, duration, state, momenta, wrenches, circuits);
  for (const std::size_t j : given_)  // sources that hold a given current do what work is done
    circuits.supply += duration * given_current(j, time) *
                       power(per_ampere_[j], duration, state, momenta, wrenches);
  if (!magnetised_.empty())
    circuits.supply += duration * power(magnetised_, duration, state, momenta, wrenches);
  for (Index b = 0; b < model_.n_bodies(); ++b) {
    if (!held(b)) continue;
    const Bearing& bearing = model_.scene.bearings[model_.bearing_of_body[b]];
    const Vec3 along = axis(b);
    const double spin = along.dot(middle(b, duration, state, momenta, wrenches[b]).spin);
    const double own = bearing.torque - bearing.friction * spin;
    wrenches[b].force = -model_.body_mass[b].mass * model_.scene.gravity;
    wrenches[b].torque = (along.dot(wrenches[b].torque) + own) * along;
    circuits.bearings -= duration * own * spin;
  }
}

}  // namespace loomstone
