// Scripted motion: pins and obstacles; and the surface points of rigid bodies.
#pragma once

#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// Targets that the user sets hold at the end of the step. `share` is the fraction of the way there
// from `state`: 1, but for parts of a step that is taken in halves.

// (n x 3) targets of prescribed rows at `time`: of the script, of the user, or where they are.
void pin_targets(const Model& model, const State& state, double time, double share, Points& target);

// Pose of an obstacle's mesh at `time`: keyframes or the user's.
RigidPose obstacle_pose(const Model& model, const State& state, int obstacle, double time,
                        double share);

// World positions of all obstacle vertices at `time`, end to end.
void obstacle_vertices(const Model& model, const State& state, double time, double share,
                       Points& vertices);

// Obstacles for the rigid-body world; `state` is that at `time`.
std::vector<RigidObstacle> rigid_obstacles(const Model& model, const State& state, double time);
ObstaclePlaces obstacle_places(const Model& model, const State& state, double time, double share);

// World positions of a body's surface.
void body_vertices(const Model& model, const RigidState& rigid, int body,
                   Eigen::Ref<Points> vertices);

// All collision vertices of a state (cloth rows, bodies, obstacles).
void collision_vertices(const Model& model, const State& state, Points& vertices);

}  // namespace loomstone
