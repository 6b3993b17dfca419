#include "core/sim/step/step_error.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

namespace {

// Our choice: a towel of 640 triangles that meets a floor at 4 m/s stretches by 7 % in steps of 4
// ms and by 6 % in steps of 0.25 ms. With 0.05 the drape takes 1.7 times as long.
constexpr double strain_tolerance = 0.1;
// Our choice: this bound shortens the steps of stiff cloth, whose neglected strains are small.
constexpr double energy_tolerance = 0.2;
// Error to which parts of a given step are shortened before an attempt, in multiples of the
// tolerance. Our choice: the error is often smaller than that of the last part, and a part that is
// only slightly too long would be halved.
constexpr double expected_in_parts = 2.0;
// The same for automatic steps. Our choice: of their attempts, a tenth is repeated.
constexpr double expected_in_steps = 0.7;
// A part that is repeated aims at less than the tolerated error.
constexpr double safety = 0.8;
// Automatic steps become longer by at most this factor at a time. Our choice: with 1.5 while
// surfaces touch, a towel that meets a floor at 8 m/s stretches by 35 % where steps of 0.25 ms give
// 15 %. Steps that became shorter because contacts gained energy regain their length, or that which
// their error allows, by the larger factor.
constexpr double growth = 1.5, growth_in_contact = 1.25;
// Energy that implicit Euler may take from free motion in automatic steps, per second, as a
// fraction of the energy scale of DisplacementError::dissipation(). Our choice: a sheet that swings
// takes steps of about 5 ms. Steps are not shortened below three tenths of the largest for this,
// because motion that is not free, such as that of wrinkles that snap, shall lose its energy.
constexpr double dissipation_tolerance = 0.15;

// Factor of the length of a part at which its error becomes `tolerated`. Strain grows with the
// square of the length, its energy with the fourth power.
double length_factor(const StepError& error, double tolerated) {
  return std::min(std::sqrt(tolerated * strain_tolerance / std::max(error.strain, 1e-300)),
                  std::pow(tolerated * energy_tolerance / std::max(error.energy, 1e-300), 0.25));
}

}  // namespace

double relative_error(const StepError& error) {
  return std::max(error.strain / strain_tolerance, error.energy / energy_tolerance);
}

StepError error_of_motion(const StepContext& part, const Loads& loads, const State& state,
                          Engines& engines) {
  if (!engines.error) return {};
  return engines.error->over(engines.team, loads.x0, state.cloth.x, part.h);
}

bool too_large(const StepContext& part, const StepError& error, const Engines& engines) {
  return engines.error && part.divisible && relative_error(error) > *engines.accuracy;
}

PartResult shorter(const StepContext& part, const StepError& error, const Engines& engines) {
  const double allowed = safety * length_factor(error, *engines.accuracy) * part.length;
  PartResult result;
  result.longest = std::clamp(static_cast<int>(std::min<double>(allowed, part.length)),
                              int{StepPart::least}, part.length - 1);
  return result;
}

PartResult halved(const StepContext& part) {
  PartResult result;
  result.longest = std::max(part.length / 2, int{StepPart::least});
  result.contacts_gain = true;
  return result;
}

int expected_part(const StepContext& part, const State& state, Engines& engines) {
  if (!engines.error) return part.length;
  double share = state.cloth.expected_step / part.h;
  if (share == 0.0) {
    const StepError error = engines.error->at(engines.team, state.cloth.v, part.h);
    share = length_factor(error, expected_in_parts * *engines.accuracy);
  }
  return std::max(static_cast<int>(std::min(share, 1.0) * part.length), int{StepPart::least});
}

void expect_part(const StepContext& part, const StepError& error, const Engines& engines,
                 ClothState& cloth) {
  if (!engines.error) return;
  const double expected = part.automatic ? expected_in_steps : expected_in_parts;
  cloth.expected_step = part.h * length_factor(error, expected * *engines.accuracy);
}

double automatic_step(double largest, const State& state, Engines& engines) {
  if (!engines.error) return largest;
  double h = state.cloth.expected_step;
  if (h == 0.0) {
    const StepError error = engines.error->at(engines.team, state.cloth.v, largest);
    h = largest * length_factor(error, expected_in_steps * *engines.accuracy);
  }
  return std::clamp(h, largest / StepPart::whole, largest);
}

void expect_step(double largest, const State& start, double h, Engines& engines, State& state) {
  if (!engines.error) return;
  double& next = state.cloth.expected_step;  // the length that the error of the last part allows
  if (engines.integrator->damps()) {
    const double rate =
        engines.error->dissipation(engines.team, state.cloth.x, start.cloth.v, state.cloth.v, h);
    const double tolerated = dissipation_tolerance * *engines.accuracy;
    next = std::min(next, std::max(0.3 * largest, h * tolerated / std::max(rate, 1e-300)));
  }
  double& settled = state.cloth.settled_step;
  if (h >= settled || next <= growth * h) settled = 0.0;
  const bool quickly = state.contacts.anchors.empty() || settled > 0.0;
  next = std::min(next, (quickly ? growth : growth_in_contact) * h);
}

void note_error(const StepContext& part, const StepError& error, const Engines& engines,
                StepReport& report) {
  ErrorReport& to = report.error;
  to.strain = std::max(to.strain, error.strain);
  to.energy = std::max(to.energy, error.energy);
  to.beyond += engines.error && relative_error(error) > *engines.accuracy;
  to.least_part = to.least_part > 0.0 ? std::min(to.least_part, part.h) : part.h;
}

}  // namespace loomstone
