// State of cloth and rigid bodies within an asynchronous step, in which impulses act at several
// instants, the events. The steps of elements either are nested (nested_steps.h) or have their
// events in a queue (event_queue.h), both in core/integration/asynchronous.
#pragma once

#include <vector>

#include "core/base/rotation.h"

namespace loomstone {

struct EventBody {
  RigidPose pose;                                                 // centre of mass and orientation
  RigidPose start;                                                // pose at the start of the step
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  // world axes [m/s], [rad/s]
  double mass = 0.0;                                              // [kg]
  Mat3 inertia = Mat3::Zero();  // about the centre of mass, in body axes [kg m^2]
  int level = 0;                // in nested steps: level of its events, see EventMotion::Levels
  bool touched = false;         // a contact of cloth has pushed the body in this step

  Mat3 world_inertia(const Vec4& orientation) const {
    const Mat3 rotation = rotation_matrix(orientation);
    return rotation * inertia * rotation.transpose();
  }
  Vec3 velocity_at(const Vec3& point) const {
    return velocity + angular_velocity.cross(point - pose.position);
  }
  // Change of a point's velocity along the unit vector `direction` per unit impulse at this point
  // in the same direction [1/kg].
  double inverse_mass_at(const Vec3& point, const Vec3& direction) const {
    const Vec3 arm = (point - pose.position).cross(direction);
    return 1.0 / mass + arm.dot(world_inertia(pose.orientation).inverse() * arm);
  }
  // Applies an impulse [N s] and an angular impulse about the centre of mass [N m s].
  void push(const Vec3& impulse, const Vec3& angular_impulse) {
    velocity += impulse / mass;
    angular_velocity += world_inertia(pose.orientation).inverse() * angular_impulse;
  }
  // Pose after a time [s] at the present velocities. A negative time gives an earlier pose.
  RigidPose pose_after(double time) const {
    return {pose.position + time * velocity, turned(pose.orientation, angular_velocity, time)};
  }
  // Moves the body freely for a time [s], with constant velocity and angular momentum, by a scheme
  // of order 2.
  void drift(double time) {
    const Vec3 momentum = world_inertia(pose.orientation) * angular_velocity;
    const auto rate = [&](const Vec4& q) -> Vec3 { return world_inertia(q).inverse() * momentum; };
    const Vec4 middle = turned(pose.orientation, angular_velocity, 0.5 * time);
    pose = {pose.position + time * velocity, turned(pose.orientation, rate(middle), time)};
    angular_velocity = rate(pose.orientation);
  }
};

// Cloth and bodies at one instant of a step. Between impulses, a vertex that is not attached to a
// body moves at constant velocity, and a body at constant velocity and angular momentum. The stored
// position of a vertex, or pose of a body, belongs to a time that may differ from the present time.
// ahead() and body_ahead() return the difference.
struct EventMotion {
  Points &x, &v;  // (n x 3) positions [m] and velocities [m/s] of the cloth vertices
  std::vector<EventBody>& bodies;
  // (n x 3) Change of velocity of each vertex that has an event now [m/s]. It is caused by internal
  // forces of the cloth and loads on the cloth. In nested steps, loads on attached bodies
  // contribute, too; in a queue of events, impulses of strain limits do. The rows of other vertices
  // are 0 or not used. At the start of the step, nested steps apply only half of each change, but
  // the rows contain whole changes.
  const Points& kicks;
  // Times of nested steps [s]; core/integration/asynchronous/nested_steps.h explains their levels.
  // For each level, `step` is the time between consecutive events, and `ahead` is the time from now
  // to the next event, or 0 if an event is due now. The stored position of a vertex, or pose of a
  // body, belongs to the next event of its level.
  struct Levels {
    const std::vector<std::uint8_t>& of_vertex;  // (n) level of each vertex
    const std::vector<double>&step, &ahead;      // (levels)
  };
  // Times in a queue of events, since the start of the step [s]. `of_vertex` and `of_body` contain
  // the time to which the stored position of each vertex, or pose of each body, belongs. `now` is
  // the present time.
  struct Clocks {
    const Vector &of_vertex, &of_body;
    double now;
  };
  const Levels* levels = nullptr;
  const Clocks* clocks = nullptr;  // exactly one of `levels` and `clocks` is null

  // Time to which the stored position of a vertex belongs, minus the present time [s].
  double ahead(Index vertex) const {
    if (clocks) return clocks->of_vertex[vertex] - clocks->now;
    return levels->ahead[levels->of_vertex[vertex]];
  }
  double body_ahead(Index body) const {
    if (clocks) return clocks->of_body[body] - clocks->now;
    return levels->ahead[bodies[body].level];
  }
  // Row of a vertex in `kicks` [m/s], or 0 if the vertex has no event now.
  Vec3 kick(Index vertex) const {
    return ahead(vertex) == 0.0 ? Vec3(kicks.row(vertex).transpose()) : Vec3::Zero();
  }
  // Time between consecutive events of a vertex [s]; 0 if there is a queue of events.
  double step(Index vertex) const { return levels ? levels->step[levels->of_vertex[vertex]] : 0.0; }
};

// A cloth vertex that is attached to a point of a rigid body.
struct AttachedVertex {
  Index row = 0;  // row of the cloth vertex
  int body = 0;
  Vec3 local = Vec3::Zero();  // point relative to the body's centre of mass, in body axes [m]
};

}  // namespace loomstone
