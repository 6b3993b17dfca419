// Frames, measured values and magnetic forces for output, and checkpoints for resuming a run.
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
  double share = 1.0;  // fraction of the step that has passed at this time [1]
};
// Captures a frame at a time within the last step. Positions are interpolated linearly within the
// part of the step that contains this time. Strains, and the largest stretch in the report, follow
// from these positions. Velocities are interpolated linearly between start and end of the step.
// Currents of coils without a circuit are those at this time. The marks in Frame::contact are those
// of the whole step. The number of the step, circuit currents and the rest of the report are those
// at the end of the step.
Frame capture(const State& state, const StepOutcome& outcome, const Engines& engines, FrameTime at);

// Sets the energies, the energy account, the strains and the circuit values of a report for `state`
// at `time` [s]. Collective with Measuring::Together.
void measure(const State& state, double time, const Engines& engines, Measuring how,
             StepReport& report);

// Returns the magnetic force [N] and the torque about the centre of mass [N m] on each body at
// `time` [s]. They are zero if the scene has neither magnets nor coils.
std::vector<Wrench> magnetic_forces(const State& state, double time, const Engines& engines);

Checkpoint to_checkpoint(const Model& model, const State& state, const StepOutcome& outcome);
// Sets `state` and `outcome.contact` from a checkpoint. Throws CacheError if a required table is
// missing or does not fit the scene. Sizes that vary during a run are not compared with the scene.
void from_checkpoint(const Model& model, const Checkpoint& checkpoint, State& state,
                     StepOutcome& outcome);

}  // namespace loomstone
