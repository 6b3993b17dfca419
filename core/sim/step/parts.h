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

// Function that advances the state by a part of a step. It must work on the state and the outcome
// that are given to take_parts().
using RunPart = std::function<PartResult(const StepContext& part)>;

// Takes the whole step at once or in parts. A part is divided if an attempt at it fails (see
// bisection.h), if its error is too large, if it creates too much energy, or if it loses too much
// of the work of scripts (see check_energy()). An automatic step that has not been divided is
// shortened instead, unless the attempt failed. If StepChoice::automatic is false, a part is also
// divided before an attempt if it is too long: longer than stable_part() allows if
// StepChoice::stable is positive, and longer than expected_part() allows otherwise. outcome.start
// must contain the state at the start of the step. Returns the span of the step that was taken.
StepSpan take_parts(const StepChoice& steps, Engines& engines, State& state, StepOutcome& outcome,
                    const RunPart& run);

// If there is a rigid-body world, saves its contacts and obstacle positions to `snapshot`.
void save_world(const Engines& engines, SteppedState& snapshot);
// Sets `state` to `snapshot`, and restores the rigid-body world, if there is one.
void return_to_state(const SteppedState& snapshot, Engines& engines, State& state);

}  // namespace loomstone
