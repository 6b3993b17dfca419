// Checks and measurements of a step: divergence, intersections, withheld motion, and acceleration
// in contact.
#pragma once

#include "core/sim/step/engines.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

// Throws SolverFailure if the position or velocity of a cloth vertex is not finite, or if a cloth
// vertex has moved from its position in x0 by more than 100 times Model::cloth_size.
void check_divergence(const Model& model, const Points& x0, const ClothState& cloth,
                      const char* stage);

// Counts the pairs that cloth_intersections() finds: intersecting triangles without a common
// vertex, of which at least one is cloth. Clears state.tangled if there are no such pairs and
// CollisionStage::find_tangle() finds no intersections either. If a step has ended with unresolved
// impacts (state.tangled is 2), also lists the counted pairs in outcome.forced and marks their
// cloth vertices in outcome.contact.
void count_intersections(State& state, Engines& engines, StepOutcome& outcome);

// Reports the withheld fraction of the motion of the step, and the root mean square acceleration of
// the free cloth vertices that were in contact in the step. `step` is the length of the step [s].
void measure_contacts(const Model& model, const State& state, double step, StepOutcome& outcome);

}  // namespace loomstone
