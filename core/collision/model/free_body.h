// A free rigid body. Repulsion and certification may move it as a whole.
#pragma once

#include <vector>

#include "core/base/rotation.h"
#include "core/collision/model/collision_model.h"

namespace loomstone {

struct FreeBody {
  Index surface = -1;  // index in CollisionModel::surfaces
  // (k x 3) Vertices in body axes, relative to the centre of mass [m].
  const Points* local = nullptr;
  double inverse_mass = 0.0;  // [1/kg]
  // Inverse inertia about the centre of mass in world axes, at the start of the part [1/(kg m^2)].
  Mat3 inverse_inertia = Mat3::Zero();
  // True if the body was pressed against an obstacle, directly or through other bodies, in the most
  // recent step of RigidWorld. CleanUp then does not move it.
  bool supported = false;
  // Velocity [m/s] and angular velocity [rad/s] that belong to `end` before any correction.
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
  RigidPose start, end;  // poses at the start and end of the part; corrections change `end`
  // Total corrections of `end` that change velocities: displacement and rotation vector. Divided by
  // the length of the part, they are the changes of velocity and angular velocity.
  Vec3 moved = Vec3::Zero();   // [m]
  Vec3 turned = Vec3::Zero();  // [rad]
};

// Element i is the body whose surface has CollisionSurface::body == i.
using FreeBodies = std::vector<FreeBody>;

// Returns the index of the body to which a collision vertex belongs. Returns -1 if the vertex does
// not belong to a body, or if `bodies` is empty.
inline Index body_of_vertex(const CollisionModel& model, const FreeBodies& bodies, Index vertex) {
  if (bodies.empty()) return -1;
  return model.surfaces[model.surface_of_vertex(vertex)].body;
}

// Sets the rows of x that belong to the body to the positions of its vertices at `pose`. Returns
// whether any coordinate changed.
bool place_body(const CollisionModel& model, const FreeBody& body, const RigidPose& pose,
                Points& x);

}  // namespace loomstone
