// Computes the energies of a state, and the circuit values of reports.
#pragma once

#include "core/base/report.h"
#include "core/sim/model/state.h"
#include "core/sim/step/engines.h"

namespace loomstone {

// Sets the energies and circuit values of a report for `state` at `time` [s]. Collective if
// `elasticity` is divided among ranks; see Engines::elasticity_for().
void measure_energies(const State& state, double time, const Engines& engines,
                      Elasticity& elasticity, StepReport& report);

// Like measure_energies(), but leaves out the energy of contacts. `obstacles` are the poses of the
// obstacles, which poses_of_magnets() returns. They are needed only if Engines::magnetics is set;
// otherwise, poses_of_magnets() returns none.
void measure_without_contacts(const SteppedState& state, const std::vector<RigidPose>& obstacles,
                              const Engines& engines, Elasticity& elasticity, StepReport& report);
std::vector<RigidPose> poses_of_magnets(const State& state, double time, const Engines& engines);

// kinetic_energy() returns the kinetic energy of cloth with the velocities v [J].
// potential_energy(), which is collective, returns the elastic and gravitational energy of cloth at
// the positions x [J].
double kinetic_energy(const Engines& engines, const Points& v);
double potential_energy(const Engines& engines, const Points& x);

// Sets the kinetic and gravitational energies of the bodies.
void measure_bodies(const Model& model, const RigidState& rigid, EnergyReport& energy);

}  // namespace loomstone
