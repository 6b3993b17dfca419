// Chooses the lengths of steps.
#pragma once

#include "core/integration/options.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"
#include "core/sim/step/engines.h"
#include "core/sim/step/step_context.h"

namespace loomstone {

struct StepChoice {
  double largest = 0.0;    // length of steps; if automatic, the largest length [s]
  bool automatic = false;  // true: steps may be shorter; see automatic_step() and take_parts()
  // If the step of an explicit scheme is "auto": the longest step at which cloth that is not
  // stretched is stable [s]. Otherwise 0.
  double stable = 0.0;
};

// Chooses the lengths of steps for the given options and the state at the start. Throws
// InvalidInput if the step of an implicit scheme is "auto" but its accuracy is None.
StepChoice choose_steps(const IntegratorOptions& options, const Model& model, const State& state);

// Returns the largest length with which an explicit scheme is expected to be stable from the start
// of `part` on, with a margin, in 64ths of the step (see StepPart). The result is between 1 and the
// length of the part. At the start of every eighth step, and whenever ClothState::expected_step is
// 0, computes the length from the stretch of the cloth and stores it in expected_step for the parts
// until the next measurement. steps.stable must be positive. Collective.
int stable_part(const StepContext& part, const StepChoice& steps, const Engines& engines,
                State& state);

}  // namespace loomstone
