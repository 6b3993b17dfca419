// Last stage: velocities lead the next step away from strain limits no faster than they may.
// Positions stay.
#pragma once

#include "core/sim/step/limit_and_certify.h"

namespace loomstone {

// Also reports how far strains are beyond their limits at the end of the part.
void limit_strain_rate(const StepContext& part, const Certified& certified, State& state,
                       Engines& engines, StepOutcome& outcome);

}  // namespace loomstone
