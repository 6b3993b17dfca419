// Lengths of steps.
#pragma once

#include "core/integration/options.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

struct StepChoice {
  double largest = 0.0;    // largest length of a step [s]
  bool automatic = false;  // true: steps are shorter where their error requires it
};

// Chooses the lengths of steps for the given options and the state at the start. Throws
// InvalidInput if steps are automatic but no accuracy bounds their error.
StepChoice choose_steps(const IntegratorOptions& options, const Model& model, const State& state);

}  // namespace loomstone
