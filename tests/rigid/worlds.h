// Helpers that several test files share: bodies, obstacles, and steps of a world.
#pragma once

#include <memory>
#include <vector>

#include "core/base/rotation.h"
#include "core/mesh/generators.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

inline const Vec3 gravity(0, 0, -9.81);
// A rotation about an axis that is parallel to no coordinate axis.
inline const Mat3 turn = rotation_matrix(quaternion_from_rotation_vector(Vec3(0.3, -1.1, 0.7)));

inline std::shared_ptr<const TriangleMesh> shared(TriangleMesh mesh) {
  return std::make_shared<const TriangleMesh>(std::move(mesh));
}

inline RigidBody body_of(TriangleMesh mesh, const std::string& shape,
                         const Vec3& position = Vec3::Zero()) {
  RigidBody body;
  body.mesh = shared(std::move(mesh));
  body.shape = choice_named<BodyShape>(shape, "bodies[0].shape");
  body.position = position;
  return body;
}

inline RigidObstacle floor_of(double size, Index cells, double friction = 0.3) {
  return {shared(floor_square(size, cells)), friction, Vec3::Zero(), Vec4(1, 0, 0, 0),
          Points(0, 3)};
}

// Returns the obstacle as a deforming surface, given by its vertices instead of a pose.
inline RigidObstacle deforming(RigidObstacle obstacle) {
  obstacle.vertices = obstacle.mesh->vertices();
  return obstacle;
}

// Takes n_steps steps without impulses. All obstacles have the identity pose.
inline void run(RigidWorld& world, RigidState& state, double step, int n_steps,
                std::size_t n_obstacles) {
  const Points none = Points::Zero(state.positions.rows(), 3);
  const std::vector<RigidPose> poses(n_obstacles);
  for (int i = 0; i < n_steps; ++i) world.advance(step, {none, none}, poses, state);
}

}  // namespace loomstone
