// Frames of a state for people, checkpoints for resuming.
#pragma once

#include "core/base/checkpoint.h"
#include "core/base/frame.h"
#include "core/sim/model/state.h"
#include "core/sim/step/engines.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

// A time within the last step.
struct FrameTime {
  double time = 0.0;   // [s]
  double share = 1.0;  // of the way from the start of the step to its end [1]
};
// Positions are interpolated linearly within the step, all else is that of its end.
Frame capture(const State& state, const StepOutcome& outcome, const Engines& engines, FrameTime at);

// Fills energies, strains and circuits of a report, at `time` [s].
void measure(const State& state, double time, const Engines& engines, StepReport& report);

// Magnetic force and torque on each body at `time` [s]; zero without magnets.
std::vector<Wrench> magnetic_forces(const State& state, double time, const Engines& engines);

Checkpoint to_checkpoint(const Model& model, const State& state, const StepOutcome& outcome);
// Throws CacheError where the checkpoint is of another scene.
void from_checkpoint(const Model& model, const Checkpoint& checkpoint, State& state,
                     StepOutcome& outcome);

}  // namespace loomstone
