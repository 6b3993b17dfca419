// Rotations as unit quaternions (w, x, y, z), matrices and rotation vectors [rad], and poses of
// rigid bodies.
#pragma once

#include <cmath>

#include "core/base/types.h"

namespace loomstone {

inline Eigen::Quaterniond to_quaternion(const Vec4& q) { return {q[0], q[1], q[2], q[3]}; }
inline Vec4 to_vector(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

inline Mat3 rotation_matrix(const Vec4& orientation) {
  return to_quaternion(orientation).toRotationMatrix();
}
inline Vec4 quaternion_from_matrix(const Mat3& rotation) {
  return to_vector(Eigen::Quaterniond(rotation).normalized());
}

// Returns `orientation` or its negative, whichever is closer to `reference`. A quaternion and its
// negative represent the same rotation.
inline Vec4 nearer_sign(const Vec4& orientation, const Vec4& reference) {
  return orientation.dot(reference) < 0.0 ? Vec4(-orientation) : orientation;
}

// Returns the rotation that applies `second` and then `first`, like the product of their rotation
// matrices.
inline Vec4 quaternion_product(const Vec4& first, const Vec4& second) {
  return to_vector(to_quaternion(first) * to_quaternion(second));
}

inline Vec4 quaternion_inverse(const Vec4& orientation) {
  return {orientation[0], -orientation[1], -orientation[2], -orientation[3]};
}

inline Vec4 quaternion_from_rotation_vector(const Vec3& rotation) {
  const double half = 0.5 * rotation.norm();
  // The factor is sin(half) / (2 half). If half < 1e-4, the truncated series is exact in double
  // precision.
  const double factor = half < 1e-4 ? 0.5 * (1.0 - half * half / 6.0) : 0.5 * std::sin(half) / half;
  Vec4 q;
  q << std::cos(half), factor * rotation;
  return q;
}

// Returns the rotation vector of the rotation along the shorter arc. Its length is in [0, pi].
inline Vec3 rotation_vector(const Vec4& orientation) {
  const Vec4 q = orientation[0] < 0.0 ? Vec4(-orientation) : orientation;
  const double sine = q.tail<3>().norm();
  if (sine == 0.0) return Vec3::Zero();
  return q.tail<3>() * (2.0 * std::atan2(sine, q[0]) / sine);
}

// Returns the orientation after a time `step` [s] at constant angular velocity in world axes
// [rad/s].
inline Vec4 turned(const Vec4& orientation, const Vec3& angular_velocity, double step) {
  return quaternion_product(quaternion_from_rotation_vector(angular_velocity * step), orientation)
      .normalized();
}

// Returns the constant angular velocity in world axes [rad/s] that leads from `start` to `end` in
// `step` [s] along the shorter arc.
inline Vec3 angular_velocity_between(const Vec4& start, const Vec4& end, double step) {
  return rotation_vector(quaternion_product(end, quaternion_inverse(start))) / step;
}

// Interpolates from `start` (share 0) to `end` (share 1) with constant angular velocity along the
// shorter arc.
inline Vec4 slerp(const Vec4& start, const Vec4& end, double share) {
  return quaternion_product(
             quaternion_from_rotation_vector(share * angular_velocity_between(start, end, 1.0)),
             start)
      .normalized();
}

// Position and orientation of a rigid body, an obstacle, a magnet or a coil.
struct RigidPose {
  Vec3 position = Vec3::Zero();         // position of the body's origin [m]
  Vec4 orientation = Vec4(1, 0, 0, 0);  // unit quaternion (w, x, y, z), body to world
};

inline bool operator==(const RigidPose& a, const RigidPose& b) {
  return a.position == b.position && a.orientation == b.orientation;
}

// Interpolates from `start` (share 0) to `end` (share 1) with constant velocity and angular
// velocity. For shares 0 and 1, the result is bitwise equal to `start` and `end`, respectively.
inline RigidPose between(const RigidPose& start, const RigidPose& end, double share) {
  if (share == 0.0) return start;
  if (share == 1.0) return end;
  return {start.position + share * (end.position - start.position),
          slerp(start.orientation, end.orientation, share)};
}

// Sets `world` (k x 3) to the world positions of points given in body axes.
inline void place_points(const RigidPose& pose, const Points& local, Eigen::Ref<Points> world) {
  const Mat3 rotation = rotation_matrix(pose.orientation);
  for (Index i = 0; i < local.rows(); ++i)
    world.row(i) = (pose.position + rotation * local.row(i).transpose()).transpose();
}

}  // namespace loomstone
