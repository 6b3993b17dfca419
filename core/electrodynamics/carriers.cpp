#include "core/electrodynamics/carriers.h"

namespace loomstone {

void add_times(CarrierWrenches& to, double factor, const CarrierWrenches& what) {
  for (std::size_t b = 0; b < to.size(); ++b) {
    to[b].force += factor * what[b].force;
    to[b].torque += factor * what[b].torque;
  }
}

RigidPose CarrierPlaces::pose(Index carrier, const RigidPose& local) const {
  const Index n = static_cast<Index>(bodies.positions.rows());
  const RigidPose pose = carrier < n ? body_pose(bodies, carrier) : obstacles[carrier - n];
  return {pose.position + rotation_matrix(pose.orientation) * local.position,
          quaternion_product(pose.orientation, local.orientation)};
}

Points CarrierPlaces::centres() const {
  const Eigen::Index n = bodies.positions.rows();
  Points centres(n + static_cast<Eigen::Index>(obstacles.size()), 3);
  centres.topRows(n) = bodies.positions;
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    centres.row(n + static_cast<Eigen::Index>(i)) = obstacles[i].position.transpose();
  return centres;
}

std::vector<Twist> obstacle_twists(const std::vector<RigidPose>& from,
                                   const std::vector<RigidPose>& to, double step) {
  std::vector<Twist> twists(from.size());
  for (std::size_t i = 0; i < twists.size(); ++i) {
    const Vec4 &start = from[i].orientation, &end = to[i].orientation;
    twists[i].velocity = (to[i].position - from[i].position) / step;
    twists[i].spin = start == end ? Vec3(Vec3::Zero()) : angular_velocity_between(start, end, step);
  }
  return twists;
}

}  // namespace loomstone
