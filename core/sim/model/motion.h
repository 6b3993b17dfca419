// Positions of pins and obstacles according to scripts, and surface vertices of rigid bodies.
#pragma once

#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// In these functions, `share` is the fraction of the motion from `state` to the targets and poses
// set by the user that is complete at `time` [s]. It is 1 when they are reached (see
// State::target_time).

// Sets `target` (n x 3) to the positions of scripted pins at `time` and to the targets set by the
// user. All other rows are the current positions.
void pin_targets(const Model& model, const State& state, double time, double share, Points& target);

// Returns the pose of an obstacle's mesh at `time`. It follows from the keyframes. If the user has
// set a pose, it follows from that pose and `share` instead.
RigidPose obstacle_pose(const Model& model, const State& state, int obstacle, double time,
                        double share);

// Computes the world positions of all obstacle vertices at `time`, concatenated.
void obstacle_vertices(const Model& model, const State& state, double time, double share,
                       Points& vertices);

// These two functions return the obstacles for the rigid-body world. In rigid_obstacles(), `state`
// is the state at `time`.
std::vector<RigidObstacle> rigid_obstacles(const Model& model, const State& state, double time);
ObstaclePlaces obstacle_places(const Model& model, const State& state, double time, double share);

// Computes the world positions of the surface vertices of a body.
void body_vertices(const Model& model, const RigidState& rigid, int body,
                   Eigen::Ref<Points> vertices);

// Computes the world positions of all collision vertices of a state. Cloth rows come first, then
// bodies, then obstacles.
void collision_vertices(const Model& model, const State& state, Points& vertices);

}  // namespace loomstone
