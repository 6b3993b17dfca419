#include "core/sim/record/frame_magnets.h"

#include <Eigen/Geometry>

#include "core/base/message.h"
#include "core/electrodynamics/magnets.h"

namespace loomstone {

namespace {

// Returns the pose that maps `local` to `world` with the least sum of squared deviations.
RigidPose fitted_pose(const Points& local, const Points& world) {
  const Eigen::Matrix4d fit = Eigen::umeyama(Eigen::Matrix3Xd(local.transpose()),
                                             Eigen::Matrix3Xd(world.transpose()), false);
  return {fit.topRightCorner<3, 1>(), quaternion_from_matrix(fit.topLeftCorner<3, 3>())};
}

}  // namespace

std::vector<MagneticBody> magnets_of_frame(const Team& team, const Model& model,
                                           const Frame& frame) {
  const Index wanted = static_cast<Index>(model.topology.body_of_vertex.size());
  if (frame.body_vertices.rows() != wanted)
    fail<InvalidInput>(
        "the frame must have the {} vertices of this scene's bodies and obstacles, got {}; take "
        "frame and scene from the same run",
        wanted, frame.body_vertices.rows());
  RigidState state;
  state.positions.resize(model.n_bodies(), 3);
  state.orientations.resize(model.n_bodies(), 4);
  std::vector<RigidPose> obstacles;
  Index row = 0;
  const auto next = [&](const Points& local) {
    const RigidPose pose = fitted_pose(local, frame.body_vertices.middleRows(row, local.rows()));
    row += static_cast<Index>(local.rows());
    return pose;
  };
  for (Index b = 0; b < model.n_bodies(); ++b) {
    const RigidPose pose = next(model.bodies[b].local);
    state.positions.row(b) = pose.position.transpose();
    state.orientations.row(b) = pose.orientation.transpose();
  }
  for (const Model::Surface& obstacle : model.obstacles) obstacles.push_back(next(obstacle.local));
  return shown_magnets(team, model.magnetics, {state, obstacles}, frame.coil_currents);
}

}  // namespace loomstone
