// Fourth stage: moves the rigid bodies under gravity, magnetic forces, impulses from the cloth, and
// contacts with bodies and obstacles.
#pragma once

#include "core/sim/step/integrate.h"

namespace loomstone {

// The difference of the velocities in `solved` from the prediction in `loads` gives the impulses of
// the cloth. Bodies that the integrator has moved take its poses where they move freely, and
// attached vertices follow the others. Returns the work of scripted obstacles on bodies, by
// contacts and by magnets [J].
double move_bodies(const StepContext& part, const Loads& loads, const SolvedBodies& solved,
                   State& state, Engines& engines, StepReport& report);

}  // namespace loomstone
