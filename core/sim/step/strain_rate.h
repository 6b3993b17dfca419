// Sixth stage: if a cloth has strain limits, corrects its velocities so that, within the length of
// the part, they change strains by at most LimitOptions::strain_rate (0: no correction). Positions
// do not change.
#pragma once

#include "core/sim/step/limit_and_certify.h"
#include "core/sim/step/work.h"

namespace loomstone {

// Limits the strain rate, except in asynchronous steps, and reports the excess over strain limits
// at the end of the part. Copies the cloth to `solved` before it changes velocities. Returns the
// energy that it removes from cloth [J].
double limit_strain_rate(const StepContext& part, const Certified& certified, Solved& solved,
                         State& state, Engines& engines, StepOutcome& outcome);

}  // namespace loomstone
