#include "core/sim/step/energies.h"

#include "core/electrodynamics/coil_currents.h"
#include "core/sim/model/motion.h"

namespace loomstone {

namespace {

double magnetic_energy(const State& state, double time, const Engines& engines) {
  if (!engines.magnetics) return 0.0;
  return engines.magnetics->energy(
      engines.team, {state.rigid, obstacle_places(engines.model, state, time, 0.0).poses},
      state.magnetic.moments);
}

void measure_circuits(const Model& model, const CircuitState& circuits, CircuitReport& report) {
  report.current = first_circuit_current(model.magnetics, circuits);
  report.energy = circuits.energy;
  report.heat = circuits.heat;
  report.supply = circuits.supply;
  report.bearing_work = circuits.bearings;
}

}  // namespace

void measure_bodies(const Model& model, const RigidState& rigid, EnergyReport& energy) {
  energy.body_kinetic = energy.body_gravity = 0.0;
  for (Index b = 0; b < model.n_bodies(); ++b) {
    const double mass = model.body_mass[b].mass;
    const Vec3 spin = rigid.angular_velocities.row(b).transpose();
    const Mat3 inertia = world_inertia(model.body_mass[b], rigid.orientations.row(b).transpose());
    energy.body_kinetic +=
        0.5 * (mass * rigid.velocities.row(b).squaredNorm() + spin.dot(inertia * spin));
    energy.body_gravity -= mass * rigid.positions.row(b).dot(model.scene.gravity.transpose());
  }
}

void measure_energies(const State& state, double time, const Engines& engines, StepReport& report) {
  const Model& model = engines.model;
  const Index n = model.cloth.n_vertices;
  const Points &x = state.cloth.x, &v = state.cloth.v;
  const Vector& mass = model.cloth.mass;
  const auto kinetic = [&](Index i) { return 0.5 * mass[i] * v.row(i).squaredNorm(); };
  const auto moment = [&](Index i) {
    return mass[i] * x.row(i).dot(model.scene.gravity.transpose());
  };
  EnergyReport& energy = report.energy;
  energy.kinetic = parallel_sum(engines.team, n, kinetic);
  energy.gravity = -parallel_sum(engines.team, n, moment);
  measure_bodies(model, state.rigid, energy);
  measure_circuits(model, state.magnetic.circuits, report.circuits);
  energy.magnetic = magnetic_energy(state, time, engines);
  if (n == 0) return;
  energy.membrane = engines.elasticity->membrane_energy(engines.team, x);
  energy.bending = engines.elasticity->bending_energy(engines.team, x);
}

}  // namespace loomstone
