// Lengths of steps.
#pragma once

#include "core/integration/options.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

struct StepChoice {
  double largest = 0.0;    // [s]
  bool automatic = false;  // steps are shorter where their error requires it
};

// Chooses the lengths that options ask for. The state is that of the start. Throws InvalidInput if
// the step is automatic but its error is not bounded.
StepChoice choose_steps(const IntegratorOptions& options, const Model& model, const State& state);

}  // namespace loomstone
