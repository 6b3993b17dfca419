// Pictures and saves of a state: frames for people, checkpoints for resuming.
#pragma once

#include "core/base/checkpoint.h"
#include "core/base/frame.h"
#include "core/cloth/elasticity.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"
#include "core/sim/step/engines.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

// Frame `share` of the way from the start of the last step (0) to its end (1); positions are
// interpolated linearly, all else is that of the end.
Frame capture(const Model& model, const State& state, const StepOutcome& outcome, const Team& team,
              Elasticity& elasticity, double step, double share);

// Fills the energies (but the magnetic one) and the largest stretch of a report.
void measure(const Model& model, const State& state, const Team& team, Elasticity& elasticity,
             StepReport& report);

// Magnetic force and torque on each body at `time` [s], and the energy of all magnets [J]; nothing
// without magnets.
std::vector<Wrench> magnetic_forces(const Model& model, const State& state, double time,
                                    const Engines& engines);
double magnetic_energy(const Model& model, const State& state, double time, const Engines& engines);

Checkpoint to_checkpoint(const Model& model, const State& state, const StepOutcome& outcome);
// Throws CacheError where the checkpoint is of another scene.
void from_checkpoint(const Model& model, const Checkpoint& checkpoint, State& state,
                     StepOutcome& outcome);

}  // namespace loomstone
