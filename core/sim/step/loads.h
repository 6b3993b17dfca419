// First stage: where everything is when a part of a step begins, the forces there, and where
// scripts lead by its end.
#pragma once

#include <vector>

#include "core/sim/model/state.h"
#include "core/sim/step/engines.h"
#include "core/sim/step/step_context.h"

namespace loomstone {

struct Loads {
  Points x0;              // (vertices x 3) of all that collides, at the start [m]
  Points target;          // (n x 3) where prescribed cloth vertices are at the end [m]
  Points next_obstacles;  // (k x 3) obstacle vertices at the end [m]
  Points force;  // (n x 3) of gravity, drag and the user at the start; rows of this rank [N]
  // Bodies have two rows each: translation and rotation.
  std::vector<RigidPose> body_poses;  // (b) at the start
  std::vector<Mat3> body_mass;  // (2 b) mass times identity [kg], inertia in world axes [kg m^2]
  Points body_velocity;  // (2 b x 3) that the bodies' stage will give them by itself [m/s, rad/s]
};

void find_loads(const StepContext& part, const State& state, const Engines& engines, Loads& loads);

}  // namespace loomstone
