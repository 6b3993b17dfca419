// Fourth stage: moves the rigid bodies under gravity, magnetic forces, impulses from the cloth, and
// contacts with bodies and obstacles.
#pragma once

#include "core/sim/step/loads.h"

namespace loomstone {

// body_velocity (2 b x 3): velocities after the solve. The difference from the prediction in
// `loads` gives the impulses of the cloth. Returns the work of scripted obstacles on bodies, by
// contacts and by magnets [J].
double move_bodies(const StepContext& part, const Loads& loads, const Points& body_velocity,
                   State& state, Engines& engines, StepReport& report);

}  // namespace loomstone
