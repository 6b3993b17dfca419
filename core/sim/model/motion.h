// What moves by script: pins, obstacles, and the surface points that rigid bodies carry along.
#pragma once

#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// What the user has set is the end of the step; `share` is the part of the way there from `state`,
// 1 but within halved steps.

// Targets of pinned rows at `time`: the script, the user's target, or the place they are in. (n x
// 3)
void pin_targets(const Model& model, const State& state, double time, double share, Points& target);

// Pose of an obstacle's mesh at `time`: keyframes or the user's.
RigidPose obstacle_pose(const Model& model, const State& state, int obstacle, double time,
                        double share);

// World positions of all obstacle vertices at `time`, end to end.
void obstacle_vertices(const Model& model, const State& state, double time, double share,
                       Points& vertices);

// Obstacles as rigid bodies meet them; `state` is the one at `time`.
std::vector<RigidObstacle> rigid_obstacles(const Model& model, const State& state, double time);
ObstaclePlaces obstacle_places(const Model& model, const State& state, double time, double share);

// World positions of a body's surface.
void body_vertices(const Model& model, const RigidState& rigid, int body,
                   Eigen::Ref<Points> vertices);

// All collision vertices of a state (cloth rows, bodies, obstacles).
void collision_vertices(const Model& model, const State& state, Points& vertices);

}  // namespace loomstone
