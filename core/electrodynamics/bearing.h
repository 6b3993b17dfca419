// Description of a bearing in a scene.
#pragma once

#include <string>

#include "core/base/field.h"
#include "core/base/types.h"

namespace loomstone {

// A bearing restricts a body to rotation about an axis through its centre of mass. Contacts turn
// the body but do not move its centre.
struct Bearing {
  std::string body;
  Vec3 axis = Vec3(0, 0, 1);
  double friction = 0.0, torque = 0.0;

  static auto fields() {
    using B = Bearing;
    return std::make_tuple(
        field("body", &B::body, "name of the rigid body"),
        field("axis", &B::axis, "(3) direction in space, a principal axis of the body's inertia"),
        field("friction", &B::friction, "N m s", non_negative(),
              "viscous friction: braking torque over angular velocity"),
        field("torque", &B::torque, "N m", unlimited(),
              "driving torque about the axis; a load if it opposes the rotation"));
  }
};

}  // namespace loomstone
