// Coil currents at a given time, and coils as field sources.
#pragma once

#include <vector>

#include "core/electrodynamics/magnetic_model.h"
#include "core/electrodynamics/magnetic_state.h"

namespace loomstone {

// given_current() returns the current of a coil without a circuit [A], and source_voltage() the
// voltage of a circuit's source [V], at `time` [s].
double given_current(const Coil& coil, double time);
double source_voltage(const Coil& coil, double time);

// Returns the currents of all coils (coils) [A] at `time` [s]. `circuits` contains the currents of
// the coils in MagneticModel::circuits [A], in the order of that list. If `circuits` is empty,
// these currents are zero. The other coils have given currents.
Vector currents_at(const MagneticModel& model, double time, const Vector& circuits = {});
// Returns the currents of all coils (coils) [A]: the circuit currents of the state `circuits`, and
// the given currents at `time` [s].
Vector coil_currents(const MagneticModel& model, const CircuitState& circuits, double time);
// Returns the current of the first coil in MagneticModel::circuits [A], or 0 if there is none.
double first_circuit_current(const MagneticModel& model, const CircuitState& circuits);

// placed_coils() returns all coils, each with a current of 1 A. carrying_coils() returns each coil
// with its current from `currents` (coils) [A], and omits coils without current.
std::vector<MagneticBody> placed_coils(const MagneticModel& model, const CarrierPlaces& places);
std::vector<MagneticBody> carrying_coils(const MagneticModel& model, const CarrierPlaces& places,
                                         const Vector& currents);

}  // namespace loomstone
