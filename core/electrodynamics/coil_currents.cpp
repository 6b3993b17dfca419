#include "core/electrodynamics/coil_currents.h"

#include "core/base/keyframes.h"

namespace loomstone {

namespace {

// Interpolates the values linearly between the times, and uses the nearest value outside their
// range. Without times, returns the first value. Returns 0 if there are no values.
double at_time(const std::vector<double>& times, const std::vector<double>& values, double time) {
  if (values.empty()) return 0.0;
  if (times.empty()) return values.front();
  const Keyframes at = keyframes_at(times, time);
  return values[at.first] + at.fraction * (values[at.second] - values[at.first]);
}

}  // namespace

double given_current(const Coil& coil, double time) {
  return at_time(coil.times, coil.currents, time);
}

double source_voltage(const Coil& coil, double time) {
  return at_time(coil.times, coil.voltages, time);
}

Vector currents_at(const MagneticModel& model, double time, const Vector& circuits) {
  Vector currents = Vector::Zero(static_cast<Eigen::Index>(model.coils.size()));
  for (const std::size_t j : model.given)
    currents[static_cast<Eigen::Index>(j)] = given_current(model.coils[j].coil, time);
  for (Eigen::Index k = 0; k < circuits.size(); ++k)
    currents[static_cast<Eigen::Index>(model.circuits[k])] = circuits[k];
  return currents;
}

Vector coil_currents(const MagneticModel& model, const CircuitState& circuits, double time) {
  Vector currents = circuits.currents;
  for (const std::size_t j : model.given)
    currents[static_cast<Eigen::Index>(j)] = given_current(model.coils[j].coil, time);
  return currents;
}

double first_circuit_current(const MagneticModel& model, const CircuitState& circuits) {
  return model.circuits.empty()
             ? 0.0
             : circuits.currents[static_cast<Eigen::Index>(model.circuits.front())];
}

std::vector<MagneticBody> placed_coils(const MagneticModel& model, const CarrierPlaces& places) {
  std::vector<MagneticBody> coils;
  for (const CarriedCoil& wound : model.coils)
    coils.push_back({wound.source, places.pose(wound.carrier, wound.local)});
  return coils;
}

std::vector<MagneticBody> carrying_coils(const MagneticModel& model, const CarrierPlaces& places,
                                         const Vector& currents) {
  std::vector<MagneticBody> coils;
  for (std::size_t j = 0; j < model.coils.size() && static_cast<Eigen::Index>(j) < currents.size();
       ++j) {
    const double current = currents[static_cast<Eigen::Index>(j)];
    if (current == 0.0) continue;
    const CarriedCoil& wound = model.coils[j];
    coils.push_back({wound.source->with_current(current), places.pose(wound.carrier, wound.local)});
  }
  return coils;
}

}  // namespace loomstone
