// Rigid motion of a body or an obstacle between two sets of positions of its vertices.
#pragma once

#include "core/collision/model/collision_model.h"

namespace loomstone {

struct RigidMotion {
  bool rigid = false;  // false: the surface deforms, or its vertices do not determine a rotation
  Mat3 rotation = Mat3::Identity();
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  // start and end positions of the first vertex [m]

  Vec3 displacement(const Vec3& x) const { return rotation * (x - from) + to - x; }
};

RigidMotion rigid_motion(const Eigen::Ref<const Points>& start,
                         const Eigen::Ref<const Points>& end);
RigidMotion rigid_motion(const CollisionModel& model, Index surface, const Points& x0,
                         const Points& x1);

}  // namespace loomstone
