// Fourth stage: rigid bodies move, under the impulses that the cloth's solve gives them, loads,
// magnets and contacts with one another.
#pragma once

#include "core/sim/step/loads.h"

namespace loomstone {

// body_velocity: (2 b x 3) as the solve has left them; loads have the prediction.
void move_bodies(const StepContext& part, const Loads& loads, const Points& body_velocity,
                 State& state, Engines& engines, StepReport& report);

}  // namespace loomstone
