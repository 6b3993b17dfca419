#include "core/electrodynamics/kick.h"

#include <cmath>

#include "core/electrodynamics/coil_currents.h"

namespace loomstone {

namespace {

// Number of fixed-point iterations in a kick if circuits act on each other or magnetise bodies. The
// wrenches per ampere of the circuits then depend on the currents.
constexpr int rounds = 4;

// Rotation of a body in a bearing during a kick.
struct Turning {
  double spin = 0.0;    // angular velocity at which friction acts [rad/s]
  double torque = 0.0;  // total torque about the axis [N m]
  double taken = 0.0;   // energy that the bearing takes [J]
};

// Wrenches per ampere of each circuit: `felt` determines the back-EMF, `exerted` acts on the
// bodies.
struct Couplings {
  std::vector<CarrierWrenches> felt, exerted;
};

// Circuits at the start of a kick, and their linear system without back-EMF.
struct CircuitSystem {
  // (circuits) 1: the current at the end of the kick acts instead of the mean; see kick.h
  std::vector<std::uint8_t> at_end;
  // (circuits x circuits) c L / tau + R [ohm], with the symbols of kick.h. The factor c is 1 for
  // the columns of circuits marked in `at_end`, and 2 for other columns.
  Eigen::MatrixXd matrix;
  // (circuits) Currents at the start [A], source voltages [V], flux changes due to given currents
  // [V s], right-hand side [V].
  Vector before, voltages, induced, right;
};

class Kick {
 public:
  Kick(const MagneticModel& model, const KickStart& start) : model_(model), start_(start) {}

  // Advances the circuits and adds their wrenches to `wrenches`.
  void advance_circuits(CarrierWrenches& wrenches, CircuitState& circuits) const;
  // Returns the power of the wrenches `felt` on bodies [W], or the power per ampere [W/A] if `felt`
  // contains wrenches per ampere. The velocities of the bodies are those of middle() in a kick by
  // `wrenches`.
  double power(const CarrierWrenches& felt, const CarrierWrenches& wrenches) const;
  // Returns the rotation of a body in a bearing during a kick by `wrench`. Turning::spin is the
  // angular velocity at the midpoint, or at the end if friction is strong; see kick.h.
  Turning turning(Index body, const Wrench& wrench) const;
  // Returns the linear and angular velocity of a body at the midpoint of a kick by `wrench`. For a
  // body in a bearing, the angular velocity is that of turning().
  Twist middle(Index body, const Wrench& wrench) const;

 private:
  double scripted_power(const CarrierWrenches& per_ampere) const;
  CircuitSystem system(const CircuitState& circuits) const;
  Couplings couplings(const Vector& acting_currents) const;
  Vector acting_currents(const CircuitSystem& system, const Couplings& couplings,
                         const CarrierWrenches& wrenches) const;

  const MagneticModel& model_;
  const KickStart& start_;
};

Turning Kick::turning(Index body, const Wrench& wrench) const {
  const double duration = start_.duration;
  const MagneticRotor& rotor = model_.bodies[body];
  const Bearing& bearing = *rotor.bearing;
  const Vec4 orientation = start_.bodies.orientations.row(body).transpose();
  const double inertia = bearing.axis.dot(world_inertia(rotor.mass, orientation) * bearing.axis);
  const double momentum = bearing.axis.dot(start_.momenta.row(body).transpose());
  const double given = bearing.axis.dot(wrench.torque) + bearing.torque;  // without friction
  const bool at_end = duration * bearing.friction > 2.0 * inertia;
  const double passed = at_end ? duration : 0.5 * duration;
  Turning turning;
  turning.spin = (momentum + passed * given) / (inertia + passed * bearing.friction);
  turning.torque = given - bearing.friction * turning.spin;
  turning.taken = duration * (bearing.friction * turning.spin - bearing.torque) * turning.spin;
  if (at_end) turning.taken += 0.5 * std::pow(duration * turning.torque, 2) / inertia;
  return turning;
}

Twist Kick::middle(Index body, const Wrench& wrench) const {
  const double duration = start_.duration;
  const MagneticRotor& rotor = model_.bodies[body];
  const Vec3 momentum = start_.momenta.row(body).transpose();
  const Vec4 orientation = start_.bodies.orientations.row(body).transpose();
  if (rotor.bearing) return {Vec3::Zero(), turning(body, wrench).spin * rotor.bearing->axis};
  const Vec3 start = start_.bodies.velocities.row(body).transpose();
  return {start + 0.5 * duration * (wrench.force / rotor.mass.mass + model_.gravity),
          angular_velocity(rotor.rotor, orientation, momentum + 0.5 * duration * wrench.torque)};
}

double Kick::power(const CarrierWrenches& felt, const CarrierWrenches& wrenches) const {
  double sum = 0.0;
  for (Index b = 0; b < model_.n_bodies(); ++b) {
    const Twist twist = middle(b, wrenches[b]);
    sum += felt[b].force.dot(twist.velocity) + felt[b].torque.dot(twist.spin);
  }
  return sum;
}

// Returns the power per ampere of the wrenches on scripted obstacles [W/A].
double Kick::scripted_power(const CarrierWrenches& per_ampere) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < start_.twists.size(); ++i) {
    const Wrench& wrench = per_ampere[model_.n_bodies() + i];
    sum += wrench.force.dot(start_.twists[i].velocity) + wrench.torque.dot(start_.twists[i].spin);
  }
  return sum;
}

CircuitSystem Kick::system(const CircuitState& circuits) const {
  const double time = start_.time, duration = start_.duration;
  const Inductances& inductances = start_.actions.inductances;
  const auto m = static_cast<Eigen::Index>(model_.circuits.size());
  CircuitSystem system{
      std::vector<std::uint8_t>(m), inductances.own, Vector(m), Vector(m), Vector::Zero(m), {}};
  Vector change(model_.given.size());
  for (std::size_t g = 0; g < model_.given.size(); ++g) {
    const Coil& coil = model_.coils[model_.given[g]].coil;
    change[g] =
        given_current(coil, time + 0.5 * duration) - given_current(coil, time - 0.5 * duration);
  }
  if (!model_.given.empty()) system.induced = inductances.from_given * change;
  Vector weights(m);
  for (Eigen::Index a = 0; a < m; ++a) {
    const std::size_t j = model_.circuits[a];
    const Coil& coil = model_.coils[j].coil;
    system.at_end[a] =
        coil.inductance > 0.0 && duration * coil.resistance > 2.0 * inductances.own(a, a);
    weights[a] = system.at_end[a] ? 1.0 : 2.0;
    system.before[a] = circuits.currents[j];
    system.voltages[a] = start_.actions.coils.sense[j] * source_voltage(coil, time);
    system.matrix.col(a) *= weights[a] / duration;
    system.matrix(a, a) += coil.resistance;
  }
  const Vector stored = 1.0 / duration * (inductances.own * weights.cwiseProduct(system.before));
  system.right = stored + system.voltages - system.induced / duration;
  return system;
}

Couplings Kick::couplings(const Vector& acting_currents) const {
  const CoilForces& coils = start_.actions.coils;
  Couplings result;
  for (const std::size_t j : model_.circuits) result.felt.push_back(coils.per_ampere[j]);
  result.exerted = result.felt;
  const auto act = [&](std::size_t own, std::size_t other, const CarrierWrenches& what) {
    const double current = acting_currents[static_cast<Eigen::Index>(other)];
    add_times(result.felt[own], current, what);
    add_times(result.exerted[own], 0.5 * current, what);
  };
  for (const CircuitResponse::Pair& pair : coils.pairs) {
    act(pair.j, pair.k, pair.wrenches);
    if (pair.j != pair.k) act(pair.k, pair.j, pair.wrenches);
  }
  return result;
}

// Solves (c L / tau + R) i_m + E(i_m) = c L i / tau + V - M di_g / tau for i_m, with the symbols of
// kick.h and CircuitSystem. di_g is the change of the given currents in the kick. The back-EMF E of
// a circuit is the power of its wrenches per ampere (Couplings::felt) on bodies and scripted
// obstacles. For given couplings, E is an affine function of the wrenches on the bodies, and
// therefore of i_m.
Vector Kick::acting_currents(const CircuitSystem& system, const Couplings& couplings,
                             const CarrierWrenches& wrenches) const {
  const Eigen::Index m = system.before.size();
  Eigen::MatrixXd matrix = system.matrix;
  Vector right = system.right;
  std::vector<CarrierWrenches> with(m, wrenches);
  for (Eigen::Index k = 0; k < m; ++k) add_times(with[k], 1.0, couplings.exerted[k]);
  for (Eigen::Index j = 0; j < m; ++j) {
    // Power without circuit currents. Its increase per ampere is added to `matrix`.
    const double idle = power(couplings.felt[j], wrenches);
    right[j] -= idle + scripted_power(couplings.felt[j]);
    for (Eigen::Index k = 0; k < m; ++k) matrix(j, k) += power(couplings.felt[j], with[k]) - idle;
  }
  return matrix.partialPivLu().solve(right);
}

void Kick::advance_circuits(CarrierWrenches& wrenches, CircuitState& circuits) const {
  const double duration = start_.duration;
  const CircuitSystem system = this->system(circuits);
  Vector acting = system.before;
  Couplings couplings;
  for (int round = 0; round < (start_.actions.coils.pairs.empty() ? 1 : rounds); ++round) {
    couplings = this->couplings(acting);
    acting = acting_currents(system, couplings, wrenches);
  }
  Vector after(system.before.size());
  for (Eigen::Index a = 0; a < after.size(); ++a) {
    const std::size_t j = model_.circuits[a];
    const Coil& coil = model_.coils[j].coil;
    add_times(wrenches, acting[a], couplings.exerted[a]);
    const bool mean = coil.inductance > 0.0 && !system.at_end[a];
    after[a] = mean ? 2.0 * acting[a] - system.before[a] : acting[a];
    circuits.currents[j] = after[a];
    circuits.heat += duration * coil.resistance * acting[a] * acting[a];
    circuits.supply += duration * system.voltages[a] * acting[a] - system.induced[a] * acting[a];
    circuits.supply -= duration * acting[a] * scripted_power(couplings.exerted[a]);
  }
  const Vector change = after - system.before, flux = start_.actions.inductances.own * change;
  for (Eigen::Index a = 0; a < after.size(); ++a)
    if (system.at_end[a]) circuits.heat += 0.5 * change[a] * flux[a];
  circuits.energy = 0.5 * (start_.actions.inductances.own * after).dot(after);
}

}  // namespace

CarrierWrenches kick_wrenches(const MagneticModel& model, const KickStart& start,
                              CircuitState& circuits) {
  const Kick kick(model, start);
  const Actions& actions = start.actions;
  CarrierWrenches wrenches = actions.magnets;
  const auto current = [&](std::size_t j) {
    return given_current(model.coils[j].coil, start.time);
  };
  for (const std::size_t j : model.given)
    add_times(wrenches, current(j), actions.coils.per_ampere[j]);
  if (!model.circuits.empty()) kick.advance_circuits(wrenches, circuits);
  for (const std::size_t j : model.given)  // adds the work of the sources of given currents
    circuits.supply +=
        start.duration * current(j) * kick.power(actions.coils.per_ampere[j], wrenches);
  if (!actions.magnetised.empty())
    circuits.supply += start.duration * kick.power(actions.magnetised, wrenches);
  for (Index b = 0; b < model.n_bodies(); ++b) {
    if (!model.bodies[b].bearing) continue;
    const Turning turning = kick.turning(b, wrenches[b]);
    wrenches[b].force = -model.bodies[b].mass.mass * model.gravity;
    wrenches[b].torque = turning.torque * model.bodies[b].bearing->axis;
    circuits.bearings += turning.taken;
  }
  return wrenches;
}

}  // namespace loomstone
