// Divides a step into parts if it cannot be taken at once.
#pragma once

#include <functional>

#include "core/sim/model/state.h"
#include "core/sim/step/bisection.h"
#include "core/sim/step/engines.h"
#include "core/sim/step/step_choice.h"
#include "core/sim/step/step_context.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

// Takes a part of a step. It must change the state and the outcome that take_parts() has received.
using RunPart = std::function<PartResult(const StepContext& part)>;

// Takes the whole step at once or, if this fails, in parts. If the error of an automatic step is
// too large or contacts create energy in it, the whole step is shortened instead, as long as no
// part of it is complete. outcome.start must contain the state at the start of the step.
StepSpan take_parts(const StepChoice& steps, Engines& engines, State& state, StepOutcome& outcome,
                    const RunPart& run);

// Saves the contacts of the rigid-body world to `snapshot`.
void save_world(const Engines& engines, State& snapshot);
// Sets `state` to `snapshot`, and restores the rigid-body world.
void return_to_state(const State& snapshot, Engines& engines, State& state);

}  // namespace loomstone
