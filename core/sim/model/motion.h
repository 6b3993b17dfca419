// Positions of pins and obstacles according to scripts or to the user's targets and poses, and
// surface vertices of rigid bodies.
#pragma once

#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// In the functions below, scripts are evaluated at `time` [s]. `share` [1] is the fraction of the
// motion from `state` to the user's targets and poses that has been made at this time. It is 1 when
// the targets and poses are reached (see State::target_time).

// Sets the rows of scripted pins in `target` (n x 3) [m] to their positions at `time`. If the user
// has set a target for a vertex, its row is instead the position at the fraction `share` of the way
// from the current position to the user's target. All other rows are the current positions.
void pin_targets(const Model& model, const State& state, double time, double share, Points& target);

// Returns the pose of an obstacle's mesh at `time`. It follows from the obstacle's keyframes;
// without keyframes, it is the identity. If the user has set a pose, returns instead the pose at
// the fraction `share` of the motion from the current pose to the user's pose, or the user's pose
// itself if the mesh is currently deformed.
RigidPose obstacle_pose(const Model& model, const State& state, int obstacle, double time,
                        double share);

// Computes the world positions of all obstacle vertices at `time`, concatenated.
void obstacle_vertices(const Model& model, const State& state, double time, double share,
                       Points& vertices);

// Obstacles for the rigid-body world. rigid_obstacles() returns the obstacles at `time`, which must
// be the time of `state`. Their poses are those of their keyframes. Obstacles with
// Obstacle::vertex_positions also get their vertices in `state`. Poses that the user has set are
// ignored, because obstacles reach these only in steps, and RigidState::manifolds contains the
// poses that steps have reached.
// obstacle_places() returns the results of obstacle_pose() for all obstacles, and those of
// obstacle_vertices() for obstacles with Obstacle::vertex_positions.
std::vector<RigidObstacle> rigid_obstacles(const Model& model, const State& state, double time);
ObstaclePlaces obstacle_places(const Model& model, const State& state, double time, double share);

// Computes the world positions of the surface vertices of a body.
void body_vertices(const Model& model, const RigidState& rigid, int body,
                   Eigen::Ref<Points> vertices);

// Computes the world positions of all collision vertices of a state. Cloth rows come first, then
// bodies, then obstacles.
void collision_vertices(const Model& model, const SteppedState& state, Points& vertices);

}  // namespace loomstone
