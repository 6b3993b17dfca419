#include "core/sim/model/motion.h"

#include <algorithm>
#include <optional>

#include "core/base/keyframes.h"
#include "core/collision/model/rigid_motion.h"

namespace loomstone {

namespace {

Vec3 between_rows(const Points& p, std::size_t first, std::size_t second, double fraction) {
  const Vec3 a = p.row(first), b = p.row(second);
  return fraction == 0.0 ? a : Vec3(a + fraction * (b - a));
}

// Returns the index of an obstacle's first vertex among the vertices of all obstacles.
Index first_row(const Model& model, int obstacle) {
  return model.obstacles[obstacle].first - model.obstacles.front().first;
}

// Returns the pose that the keyframes of an obstacle give, or the identity without keyframes.
RigidPose scripted_pose(const Obstacle& o, double time) {
  RigidPose pose;
  if (o.times.empty()) return pose;
  const Keyframes at = keyframes_at(o.times, time);
  if (o.positions.rows() > 0)
    pose.position = between_rows(o.positions, at.first, at.second, at.fraction);
  if (o.axis_angles.rows() > 0) {
    const Vec4 a = quaternion_from_rotation_vector(o.axis_angles.row(at.first).transpose());
    const Vec4 b = quaternion_from_rotation_vector(o.axis_angles.row(at.second).transpose());
    pose.orientation = at.fraction == 0.0 ? a : slerp(a, b, at.fraction);
  }
  return pose;
}

// Returns the current pose of an obstacle's mesh, or nullopt if the mesh is deformed.
std::optional<RigidPose> present_pose(const Model& model, const State& state, int obstacle) {
  const Points& local = model.obstacles[obstacle].local;
  const RigidMotion motion = rigid_motion(
      local, state.obstacle_vertices.middleRows(first_row(model, obstacle), local.rows()));
  if (!motion.rigid) return std::nullopt;
  return RigidPose{motion.displacement(Vec3::Zero()), quaternion_from_matrix(motion.rotation)};
}

}  // namespace

void pin_targets(const Model& model, const State& state, double time, double share,
                 Points& target) {
  target = state.cloth.x;
  for (const auto& script : model.scripts) {
    const Keyframes at = keyframes_at(script.times, time);
    const std::size_t k = script.rows.size();
    for (std::size_t i = 0; i < k; ++i)
      target.row(script.rows[i]) =
          between_rows(script.positions, at.first * k + i, at.second * k + i, at.fraction);
  }
  for (Index row = 0; row < model.cloth.n_vertices; ++row)
    if (state.pin_override[row])
      target.row(row) = share == 1.0 ? Eigen::RowVector3d(state.pin_target.row(row))
                                     : state.cloth.x.row(row) + share * (state.pin_target.row(row) -
                                                                         state.cloth.x.row(row));
}

RigidPose obstacle_pose(const Model& model, const State& state, int obstacle, double time,
                        double share) {
  if (!state.pose_override[obstacle]) return scripted_pose(model.scene.obstacles[obstacle], time);
  const RigidPose end = {state.pose_position.row(obstacle), state.pose_orientation.row(obstacle)};
  return share == 1.0 ? end
                      : between(present_pose(model, state, obstacle).value_or(end), end, share);
}

void obstacle_vertices(const Model& model, const State& state, double time, double share,
                       Points& vertices) {
  Index total = 0;
  for (const auto& surface : model.obstacles) total += static_cast<Index>(surface.local.rows());
  vertices.resize(total, 3);
  for (std::size_t o = 0; o < model.obstacles.size(); ++o) {
    const Model::Surface& surface = model.obstacles[o];
    const Obstacle& description = model.scene.obstacles[o];
    const std::size_t k = surface.local.rows();
    auto rows = vertices.middleRows(first_row(model, static_cast<int>(o)), k);
    if (description.vertex_positions.rows() > 0 && !state.pose_override[o]) {
      const Keyframes at = keyframes_at(description.times, time);
      for (std::size_t i = 0; i < k; ++i)
        rows.row(i) = between_rows(description.vertex_positions, at.first * k + i,
                                   at.second * k + i, at.fraction);
      continue;
    }
    if (share < 1.0 && state.pose_override[o] && !present_pose(model, state, static_cast<int>(o))) {
      // A deformed mesh has no pose. Its vertices move in straight lines to their places in the
      // new pose.
      Points end(surface.local.rows(), 3);
      place_points(obstacle_pose(model, state, static_cast<int>(o), time, 1.0), surface.local, end);
      const auto now = state.obstacle_vertices.middleRows(first_row(model, static_cast<int>(o)), k);
      rows = now + share * (end - now);
      continue;
    }
    place_points(obstacle_pose(model, state, static_cast<int>(o), time, share), surface.local,
                 rows);
  }
}

std::vector<RigidObstacle> rigid_obstacles(const Model& model, const State& state, double time) {
  std::vector<RigidObstacle> obstacles;
  for (std::size_t o = 0; o < model.obstacles.size(); ++o) {
    const Obstacle& description = model.scene.obstacles[o];
    const RigidPose pose = scripted_pose(description, time);
    obstacles.push_back(
        {description.mesh, description.friction, pose.position, pose.orientation, Points(0, 3)});
    if (description.vertex_positions.rows() > 0)
      obstacles.back().vertices = state.obstacle_vertices.middleRows(
          first_row(model, static_cast<int>(o)), model.obstacles[o].local.rows());
  }
  return obstacles;
}

ObstaclePlaces obstacle_places(const Model& model, const State& state, double time, double share) {
  ObstaclePlaces places;
  Points vertices;
  for (std::size_t o = 0; o < model.obstacles.size(); ++o) {
    places.poses.push_back(obstacle_pose(model, state, static_cast<int>(o), time, share));
    if (model.scene.obstacles[o].vertex_positions.rows() == 0) continue;
    if (vertices.rows() == 0) obstacle_vertices(model, state, time, share, vertices);
    const Index k = static_cast<Index>(model.obstacles[o].local.rows()),
                before = static_cast<Index>(places.deformed.rows());
    places.deformed.conservativeResize(before + k, 3);
    places.deformed.bottomRows(k) = vertices.middleRows(first_row(model, static_cast<int>(o)), k);
  }
  return places;
}

void body_vertices(const Model& model, const RigidState& rigid, int body,
                   Eigen::Ref<Points> vertices) {
  place_points(body_pose(rigid, body), model.bodies[body].local, vertices);
}

void collision_vertices(const Model& model, const SteppedState& state, Points& vertices) {
  vertices.resize(model.collision.n_vertices, 3);
  vertices.topRows(model.cloth.n_vertices) = state.cloth.x;
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    body_vertices(model, state.rigid, static_cast<int>(b),
                  vertices.middleRows(model.bodies[b].first, model.bodies[b].local.rows()));
  vertices.bottomRows(state.obstacle_vertices.rows()) = state.obstacle_vertices;
}

}  // namespace loomstone
