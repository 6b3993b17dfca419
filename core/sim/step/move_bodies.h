// Fourth stage: moves the rigid bodies under gravity, magnetic forces, the user's forces, impulses
// from the cloth, contacts with bodies and obstacles, and the constraints of bearings.
#pragma once

#include "core/sim/step/integrate.h"

namespace loomstone {

struct MovedBodies {
  // Work that scripted obstacles do on bodies through contacts and magnets [J].
  double obstacle_work = 0.0;
  // Energy that cloth gains because contacts or varying magnetic forces have changed the motion of
  // bodies, which carry their attached vertices away from where the integrator has placed them [J].
  double carried_gain = 0.0;
};

// Moves the bodies. The impulses of the cloth follow from the difference between the velocities in
// `solved` and those predicted in `loads`. If the integrator has also moved the bodies, attached
// vertices are placed at their points on the bodies. Otherwise, they move with these points where
// contacts or varying magnetic forces have changed the motion of the bodies. In scenes with
// magnets, coils or bearings, bodies move in magnetic sub-steps. The impulses on bodies that cloth
// moves then reproduce the motion of the solve, provided that magnetic forces are constant and
// nothing touches the bodies. In other scenes, bodies that the integrator has moved keep this
// motion unless contacts change it. To find such contacts, the rigid-body world moves these bodies
// again, by impulses that follow from the difference between the velocities in `solved` and those
// at the start of the part.
MovedBodies move_bodies(const StepContext& part, const Loads& loads, const SolvedBodies& solved,
                        State& state, Engines& engines, StepReport& report);

}  // namespace loomstone
