// First stage of a part of a step: finds the positions and forces at its start. For its end, finds
// the positions of prescribed vertices and obstacles, and predicts the velocities of bodies.
#pragma once

#include <vector>

#include "core/base/own_rows.h"
#include "core/sim/model/state.h"
#include "core/sim/step/engines.h"
#include "core/sim/step/step_context.h"

namespace loomstone {

struct Loads {
  Points x0;  // (vertices x 3) collision vertices at the start [m]; empty without cloth
  // v0 (n x 3): velocities of the cloth at the start [m/s]. target (n x 3): positions of prescribed
  // vertices at the end, and of other cloth vertices at the start [m]. Neither has rows if no
  // vertex is prescribed.
  Points v0, target;
  Points next_obstacles;  // (k x 3) obstacle vertices at the end [m]
  // Sum of gravity, drag and user forces on cloth at the start, in the rows of this rank [N].
  OwnRows force;
  // Tables of 2 b rows have two rows for each of the b bodies: translation and rotation.
  std::vector<RigidPose> body_poses;  // (b) poses at the start
  std::vector<Mat3> body_mass;  // (2 b) mass times identity [kg], inertia in world axes [kg m^2]
  // (2 b x 3) velocities predicted for the end of the part [m/s, rad/s], without the effects of
  // cloth and contacts; if there is no cloth, also without magnetic forces
  Points body_velocity;
  Points body_angular_velocity;  // (b x 3) angular velocities at the start [rad/s]
  // (2 b x 3) impulses and angular impulses that the user's forces and torques exert on the bodies
  // during this part of the step [N s, N m s]
  Points body_impulse;

  std::size_t bytes() const { return bytes_of(x0, v0, target, next_obstacles, force); }
};

struct Rows {
  Index begin, end;  // [begin, end)
};

// Returns the cloth rows that this rank owns.
Rows own_cloth_rows(const Engines& engines);

// Sets `force` [N] to the sum of gravity, drag and user forces at `time` [s] in the cloth rows
// `rows`.
void find_cloth_forces(double time, const State& state, const Engines& engines, Rows rows,
                       RowsOut force);

// Returns whether a script or a target of the user moves any prescribed vertex in the part.
bool pins_move(const ClothModel& cloth, const Loads& loads);

void find_loads(const StepContext& part, const State& state, const Engines& engines, Loads& loads);

}  // namespace loomstone
