// Chooses the lengths of steps.
#pragma once

#include "core/integration/options.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

struct StepChoice {
  double largest = 0.0;    // length of steps; if automatic, the largest length [s]
  bool automatic = false;  // true: error, dissipation and contacts may shorten steps
};

// Chooses the lengths of steps for the given options and the state at the start. Throws
// InvalidInput if the step of an implicit scheme is "auto" but its accuracy is not given.
StepChoice choose_steps(const IntegratorOptions& options, const Model& model, const State& state);

}  // namespace loomstone
