// A free rigid body that repulsion and certification may move, always as a whole.
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
  bool supported = false;  // rests on something immovable: clean-up treats it as immovable, too
  RigidPose start, end;    // of the centre of mass; corrections change the end
  // Total correction of the end; divided by the step it is the change of velocity and of angular
  // velocity.
  Vec3 moved = Vec3::Zero();   // [m]
  Vec3 turned = Vec3::Zero();  // [rad]
};

// Indexed by CollisionSurface::body.
using FreeBodies = std::vector<FreeBody>;

// The free body to which a collision vertex belongs, -1 for none.
inline Index body_of_vertex(const CollisionModel& model, const FreeBodies& bodies, Index vertex) {
  if (bodies.empty()) return -1;
  return model.surfaces[model.surface_of_vertex[vertex]].body;
}

// Writes the body's vertices at `pose` into x. Returns whether any bit changed.
bool place_body(const CollisionModel& model, const FreeBody& body, const RigidPose& pose,
                Points& x);

}  // namespace loomstone
