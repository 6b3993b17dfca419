// A free rigid body as repulsion, clean-up and truncation move it: always as a whole.
#pragma once

#include <vector>

#include "core/base/rotation.h"
#include "core/collision/model/collision_model.h"

namespace loomstone {

struct FreeBody {
  Index surface = -1;             // of the collision model
  const Points* local = nullptr;  // (k x 3) its vertices from the centre of mass, own axes [m]
  double inverse_mass = 0.0;      // [1/kg]
  Mat3 inverse_inertia = Mat3::Zero();  // about the centre, world axes, at the start [1/(kg m^2)]
  bool supported =
      false;  // presses on what does not give way: clean-up takes it for as heavy as that
  RigidPose start, end;  // of the centre of mass; the end is what may change
  // How the end was moved and turned in all: divided by h they are the changes of velocity and
  // angular velocity.
  Vec3 moved = Vec3::Zero();   // [m]
  Vec3 turned = Vec3::Zero();  // [rad]
};

// Bodies in the order of CollisionSurface::body.
using FreeBodies = std::vector<FreeBody>;

// The body that a collision vertex belongs to, -1 for none or for one that is not free here.
inline Index body_of_vertex(const CollisionModel& model, const FreeBodies& bodies, Index vertex) {
  if (bodies.empty()) return -1;
  return model.surfaces[model.surface_of_vertex[vertex]].body;
}

// Writes the vertices of `pose` into x. True where a bit changed.
bool place_body(const CollisionModel& model, const FreeBody& body, const RigidPose& pose,
                Points& x);

}  // namespace loomstone
