#include "core/sim/step/energies.h"

#include "core/electrodynamics/coil_currents.h"
#include "core/sim/model/motion.h"
#include "core/sim/step/near_contacts.h"

namespace loomstone {

namespace {

double gravitational_energy(const Engines& engines, const Points& x) {
  const Model& model = engines.model;
  return -parallel_sum(engines.team, model.cloth.n_vertices, [&](Index i) {
    return model.cloth.mass[i] * x.row(i).dot(model.scene.gravity.transpose());
  });
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

double kinetic_energy(const Engines& engines, const Points& v) {
  const Vector& mass = engines.model.cloth.mass;
  return parallel_sum(engines.team, engines.model.cloth.n_vertices,
                      [&](Index i) { return 0.5 * mass[i] * v.row(i).squaredNorm(); });
}

double potential_energy(const Engines& engines, const Points& x) {
  if (engines.model.cloth.n_vertices == 0) return 0.0;
  return gravitational_energy(engines, x) + engines.elasticity->membrane_energy(engines.team, x) +
         engines.elasticity->bending_energy(engines.team, x);
}

std::vector<RigidPose> poses_of_magnets(const State& state, double time, const Engines& engines) {
  if (!engines.magnetics) return {};
  return obstacle_places(engines.model, state, time, 0.0).poses;
}

void measure_without_contacts(const SteppedState& state, const std::vector<RigidPose>& obstacles,
                              const Engines& engines, Elasticity& elasticity, StepReport& report) {
  const Model& model = engines.model;
  const Points& x = state.cloth.x;
  EnergyReport& energy = report.energy;
  energy.kinetic = kinetic_energy(engines, state.cloth.v);
  energy.gravity = gravitational_energy(engines, x);
  measure_bodies(model, state.rigid, energy);
  measure_circuits(model, state.magnetic.circuits, report.circuits);
  if (engines.magnetics)
    energy.magnetic =
        engines.magnetics->energy(engines.team, {state.rigid, obstacles}, state.magnetic.moments);
  if (model.cloth.n_vertices == 0) return;
  energy.membrane = elasticity.membrane_energy(engines.team, x);
  energy.bending = elasticity.bending_energy(engines.team, x);
}

void measure_energies(const State& state, double time, const Engines& engines,
                      Elasticity& elasticity, StepReport& report) {
  measure_without_contacts(state, poses_of_magnets(state, time, engines), engines, elasticity,
                           report);
  if (engines.model.cloth.n_vertices == 0) return;
  EnergyReport& energy = report.energy;
  const std::optional<Engines::ContactEnergy>& known = engines.contact_energy;
  if (elasticity.divided() && known && known->time == time && known->tangled == state.tangled)
    energy.contact = known->energy;
  else
    energy.contact = contact_energies(state, time, engines, elasticity).back();
}

}  // namespace loomstone
