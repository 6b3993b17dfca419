// Checks of a step: whether it diverged, whether it is free of intersections, how calm its
// contacts are.
#pragma once

#include "core/sim/step/engines.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

// Throws SolverFailure where a vertex is not finite, or has moved by a hundred times the size of
// the cloth since x0 (n x 3).
void check_divergence(const Model& model, const Points& x0, const ClothState& cloth,
                      const char* stage);

// Counts intersections where the step has left impacts, until the cloth is free again.
void count_intersections(State& state, Engines& engines, StepOutcome& outcome);

// Motion withheld over the whole step, and accelerations in contact; `step`: its length
// [s].
void measure_contacts(const Model& model, const State& state, double step, StepOutcome& outcome);

}  // namespace loomstone
