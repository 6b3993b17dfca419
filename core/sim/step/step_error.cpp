#include "core/sim/step/step_error.h"

#include <algorithm>
#include <cmath>

#include "core/cloth/air.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

namespace {

// Tolerated neglected strain [1], if the accuracy is 1 (see tolerated_error()). Our choice: with
// this value, the largest stretch in 27 falls of towels onto a floor is at most 1.08 times the one
// in steps of 0.25 ms (docs/experiments/energy.md).
constexpr double strain_tolerance = 0.1;
// Tolerated energy of the neglected strain, as a fraction of the kinetic energy, if the accuracy is
// 1. Our choice: this bound shortens the steps of stiff cloth, whose neglected strains are small.
// The second value is for integrators that keep this energy: stiff sheets that swing then gain less
// than 1 % of the largest kinetic energy (docs/experiments/energy.md).
constexpr double energy_tolerance = 0.2, energy_tolerance_if_kept = 0.01;
// A part of a step of given length is divided before an attempt if its expected error is more than
// this multiple of the tolerance. Our choice: the expected error usually follows from the error of
// the previous part, and the actual error is often smaller. With the multiple 1, a part that is
// expected to be only slightly too long would be halved.
constexpr double expected_in_parts = 2.0;
// Expected error of automatic steps, divided by the tolerance. Our choice: below 1, so that few
// attempts are repeated.
constexpr double expected_in_steps = 0.7;
// Length of a repeated part, as a fraction of the length that the error allows.
constexpr double safety = 0.8;
// Largest ratios of the lengths of an automatic step and the preceding one: `growth_to_settled`
// after a step has been shortened because it created too much energy (see
// ClothState::settled_step), `slow_growth` otherwise if there are contacts or much damping, and
// `growth` in all other cases. Our choice.
constexpr double growth = 1.5, slow_growth = 1.25, growth_to_settled = 2.0;
// Upper limit of the Damping::rate that is expected in the next automatic step of implicit Euler
// [1/s], if the accuracy is 1. The rate is expected to be proportional to the length of the step.
// Our choice. This bound does not shorten steps below three tenths of the largest step, because
// motion that would need shorter steps, such as that of snapping wrinkles, should lose its energy.
constexpr double dissipation_tolerance = 0.15;
// If Damping::rate in a step exceeds this fraction of dissipation_tolerance times the accuracy, the
// next step is longer by at most the factor `slow_growth`. Our choice: long steps excite
// vibrations, but Damping::rate shows their energy only one or two steps later. At the faster
// growth, the lengths of steps oscillate between 3 and 10 ms in swings of soft sheets, which lose
// up to a third of their energy on the way down.
constexpr double slow_growth_share = 0.1;
// Tolerated product of Damping::rate and the length of a part, if the accuracy is 1 (see
// tolerated_error()). Applies to implicit Euler with steps whose length the user gives. This bound
// does not divide parts that are shorter than `least_of_fall_time` times Damping::fall_time. Our
// choice: a sheet of 0.1 to 2 m that swings down from two corners in steps of 10 ms then reaches
// the bottom at most 2.2 % too late, instead of 8 % without this bound. The bound does not divide
// steps of 4 ms in gentle motion.
constexpr double removal_tolerance = 5e-4, least_of_fall_time = 0.019;

// Tolerated product of drag_rate() and the length of a part, for an accuracy of 1. Our choice: drag
// acts with its value at the start of a part. If the product exceeded 1, drag would carry free
// cloth beyond the velocity of the air.
constexpr double drag_tolerance = 0.5;

// Upper limit of automatic steps while strain limits are forced (see NearContacts::forced), as a
// fraction of StepChoice::largest. Our choice: triangles that begin to touch an obstacle within a
// step yield only in the next step, and until then pull the other triangles along.
constexpr double share_when_forced = 0.2;

// Returns the relative error that is tolerated. The error of the motion is proportional to the
// length of a step, and the neglected strain to its square. An accuracy of a half therefore
// tolerates a quarter of the strain.
double tolerated_error(const Engines& engines) { return *engines.accuracy * *engines.accuracy; }

// Returns the tolerated energy of the neglected strain for an accuracy of 1, as a fraction of the
// kinetic energy.
double tolerated_energy(const Engines& engines) {
  return engines.integrator->keeps_neglected_energy() ? energy_tolerance_if_kept : energy_tolerance;
}

// Returns the larger of the neglected strain and its energy, each divided by its tolerance for an
// accuracy of 1.
double relative_error(const StepError& error, const Engines& engines) {
  return std::max(error.strain / strain_tolerance, error.energy / tolerated_energy(engines));
}

// Returns the factor by which the length of a part must change so that its relative error becomes
// `tolerated`. The strain is proportional to the square of the length, and its energy to the fourth
// power.
double length_factor(const StepError& error, double tolerated, const Engines& engines) {
  return std::min(
      std::sqrt(tolerated * strain_tolerance / std::max(error.strain, 1e-300)),
      std::pow(tolerated * tolerated_energy(engines) / std::max(error.energy, 1e-300), 0.25));
}

// Returns the length that the damping of implicit Euler allows for the next part of a step of given
// length [s]; infinite if it allows the whole step.
double length_by_damping(const StepContext& part, const Engines& engines, const ClothState& cloth) {
  const double tolerated = removal_tolerance * tolerated_error(engines);
  double length = INFINITY;
  for (const Damping& damping :
       engines.error->damping(engines.team, cloth.x, part.start->cloth.v, cloth.v, part.h)) {
    const double removed = std::max(damping.rate * part.h, 1e-300);
    length = std::min(length, std::max(least_of_fall_time * damping.fall_time,
                                       part.h * std::sqrt(tolerated / removed)));
  }
  return length < part.h * StepPart::whole / part.length ? length : INFINITY;
}

// Returns the length [s] that drag allows for a part that begins at time t0 [s]; infinite without
// drag. Collective.
double length_by_drag(double t0, const State& state, const Engines& engines) {
  const ClothModel& cloth = engines.model.cloth;
  const Air& air = engines.model.scene.air;
  if (!air.drags()) return INFINITY;
  const Rows rows = own_cloth_rows(engines);
  const DraggedSurface surface{t0, cloth.triangles, cloth.triangles_of_vertex, state.cloth.x,
                               state.cloth.v};
  double rate = 0.0;
  for (const double of_rank : results_of_ranks(engines.layout.communicator(), [&] {
         return drag_rate(engines.team, air, surface, cloth.mass, rows.begin, rows.end);
       }))
    rate = std::max(rate, of_rank);
  return drag_tolerance * *engines.accuracy / std::max(rate, 1e-300);
}

}  // namespace

StepError error_of_motion(const StepContext& part, const Loads& loads, const State& state,
                          Engines& engines) {
  if (!engines.error) return {};
  return engines.error->over(engines.team, loads.x0, state.cloth.x, part.h);
}

bool too_large(const StepContext& part, const StepError& error, const Engines& engines) {
  return engines.error && part.divisible &&
         relative_error(error, engines) > tolerated_error(engines);
}

PartResult shorter(const StepContext& part, const StepError& error, const Engines& engines) {
  const double allowed =
      safety * length_factor(error, tolerated_error(engines), engines) * part.length;
  PartResult result;
  result.longest = std::clamp(static_cast<int>(std::min<double>(allowed, part.length)),
                              int{StepPart::least}, part.length - 1);
  return result;
}

int expected_part(const StepContext& part, const State& state, Engines& engines) {
  if (!engines.error) return part.length;
  double share = state.cloth.expected_step / part.h;
  if (share == 0.0) {
    const StepError error = engines.error->at(engines.team, state.cloth.v, part.h);
    share = length_factor(error, expected_in_parts * tolerated_error(engines), engines);
  }
  share = std::min(share, length_by_drag(part.t0, state, engines) / part.h);
  return std::max(static_cast<int>(std::min(share, 1.0) * part.length), int{StepPart::least});
}

void expect_part(const StepContext& part, const StepError& error, const Engines& engines,
                 ClothState& cloth) {
  if (!engines.error) return;
  const double expected = part.automatic ? expected_in_steps : expected_in_parts;
  cloth.expected_step = part.h * length_factor(error, expected * tolerated_error(engines), engines);
  // Automatic steps are limited by their damping in expect_step().
  if (!part.automatic && engines.integrator->damps())
    cloth.expected_step = std::min(cloth.expected_step, length_by_damping(part, engines, cloth));
}

double automatic_step(double largest, const State& state, Engines& engines) {
  if (!engines.error) return largest;
  double h = state.cloth.expected_step;
  if (h == 0.0) {
    const StepError error = engines.error->at(engines.team, state.cloth.v, largest);
    h = largest * length_factor(error, expected_in_steps * tolerated_error(engines), engines);
  }
  h = std::clamp(h, largest / StepPart::whole, largest);
  // If a step is too long for drag, it is unstable. Drag may therefore shorten it further.
  const double least = largest / (StepPart::whole * StepPart::whole);
  return std::clamp(length_by_drag(state.time, state, engines), least, h);
}

void expect_step(double largest, const SteppedState& start, double h, const NearContacts& near,
                 Engines& engines, State& state) {
  if (!engines.error) return;
  // On entry: the length that the error of the last part of this step allows [s].
  double& next = state.cloth.expected_step;
  bool grows_slowly = !state.contacts.anchors.empty();
  if (engines.integrator->damps()) {
    double rate = 0.0;
    for (const Damping& damping :
         engines.error->damping(engines.team, state.cloth.x, start.cloth.v, state.cloth.v, h))
      rate = std::max(rate, damping.rate);
    const double tolerated = dissipation_tolerance * *engines.accuracy;
    next = std::min(next, std::max(0.3 * largest, h * tolerated / std::max(rate, 1e-300)));
    grows_slowly = grows_slowly || rate > slow_growth_share * tolerated;
  }
  double& settled = state.cloth.settled_step;
  if (h >= settled || next <= growth_to_settled * h) settled = 0.0;
  const double factor = settled > 0.0 ? growth_to_settled : grows_slowly ? slow_growth : growth;
  next = std::min(next, factor * h);
  if (!near.forced.empty()) next = std::min(next, share_when_forced * largest);
}

void note_error(const StepContext& part, const StepError& error, const Engines& engines,
                StepReport& report) {
  ErrorReport& to = report.error;
  to.strain = std::max(to.strain, error.strain);
  to.energy = std::max(to.energy, error.energy);
  to.beyond += engines.error && relative_error(error, engines) > tolerated_error(engines);
  to.least_part = to.least_part > 0.0 ? std::min(to.least_part, part.h) : part.h;
}

}  // namespace loomstone
