// Currents of coils at a time, and coils as the magnets that they make.
#pragma once

#include <vector>

#include "core/electrodynamics/magnetic_model.h"
#include "core/electrodynamics/magnetic_state.h"

namespace loomstone {

// Current given to a coil without a circuit, voltage of the source of one with a circuit, at a time
// [s] [A, V].
double given_current(const Coil& coil, double time);
double source_voltage(const Coil& coil, double time);

// (coils) given currents at a time [s], and those of circuits, in their order, if there are any; 0
// else [A].
Vector currents_at(const MagneticModel& model, double time, const Vector& circuits = {});
// (coils) the same with the circuits' currents in a state.
Vector coil_currents(const MagneticModel& model, const CircuitState& circuits, double time);
// Current of the first circuit, 0 without one [A].
double first_circuit_current(const MagneticModel& model, const CircuitState& circuits);

// All coils with one ampere; those that carry a current, with it; currents: (coils) [A].
std::vector<MagneticBody> placed_coils(const MagneticModel& model, const CarrierPlaces& places);
std::vector<MagneticBody> carrying_coils(const MagneticModel& model, const CarrierPlaces& places,
                                         const Vector& currents);

}  // namespace loomstone
