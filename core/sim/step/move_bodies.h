// Fourth stage: moves the rigid bodies under gravity, magnetic forces, the user's forces, impulses
// from the cloth, and contacts with bodies and obstacles.
#pragma once

#include "core/sim/step/integrate.h"

namespace loomstone {

struct MovedBodies {
  // Work that scripted obstacles do on bodies through contacts and magnets [J].
  double obstacle_work = 0.0;
  // Energy that cloth gains because contacts have changed the motion of bodies, which carry their
  // attached vertices away from where the integrator has placed them [J].
  double carried_gain = 0.0;
};

// The impulses of the cloth follow from the difference between the velocities in `solved` and those
// predicted in `loads`. If the integrator has also moved the bodies, attached vertices are placed
// at their points on the bodies. Without magnets, coils and bearings, bodies whose motion no
// contact changes then keep the motion that the integrator computed. With them, bodies move in the
// sub-steps of the magnets. Those with attached vertices do so by impulses that, under constant
// magnetic forces, lead to the motion of the solve.
MovedBodies move_bodies(const StepContext& part, const Loads& loads, const SolvedBodies& solved,
                        State& state, Engines& engines, StepReport& report);

}  // namespace loomstone
