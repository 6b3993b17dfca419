// Divides a step into parts where this is necessary.
#pragma once

#include <functional>

#include "core/sim/model/state.h"
#include "core/sim/step/bisection.h"
#include "core/sim/step/engines.h"
#include "core/sim/step/step_choice.h"
#include "core/sim/step/step_context.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

// Takes a part of a step, and changes the state and the outcome that take_parts() received.
using RunPart = std::function<PartResult(const StepContext& part)>;

// Takes the whole step at once or, if this fails, in parts. An automatic step that fails is
// shortened instead, as long as no part of it is complete. outcome.start must contain the state at
// the start of the step.
StepSpan take_parts(const StepChoice& steps, Engines& engines, State& state, StepOutcome& outcome,
                    const RunPart& run);

// Saves the contacts of the rigid-body world.
void save_world(const Engines& engines, State& snapshot);
// Also restores the rigid-body world.
void return_to_state(const State& snapshot, Engines& engines, State& state);

}  // namespace loomstone
