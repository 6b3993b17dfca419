// Sources at poses: fields of sets of them, forces and torques between them.
#pragma once

#include <string>
#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/dipoles.h"

namespace loomstone {

class TriangleMesh;

struct MagneticBody {
  SourcePtr source;
  RigidPose pose;  // of the source's axes; its origin is the body's centre

  Vec3 moment() const {
    return rotation_matrix(pose.orientation) * source->moment();
  }  // [A m^2], world axes
};

// (n x 3) B [T] or H [A/m] of all bodies together at (n x 3) points [m], world axes.
Points magnetic_field(const Team& team, const std::vector<MagneticBody>& bodies,
                      const ConstPointsRef& points, const std::string& quantity);
// (n x 9) dB_i/dx_j outside of magnets [T/m], world axes.
Gradients magnetic_gradient(const Team& team, const std::vector<MagneticBody>& bodies,
                            const ConstPointsRef& points);

// The two (B) of one body at once, the same bits.
struct FieldAndGradient {
  Points field;        // (n x 3) [T]
  Gradients gradient;  // (n x 9) [T/m]
};
FieldAndGradient magnetic_field_and_gradient(const Team& team, const MagneticBody& body,
                                             const ConstPointsRef& points);

// A pose as seen from another.
inline RigidPose relative_pose(const RigidPose& of, const RigidPose& in) {
  return {rotation_matrix(in.orientation).transpose() * (of.position - in.position),
          quaternion_product(quaternion_inverse(in.orientation), of.orientation)};
}

// A point in the axes of a pose.
inline Vec3 in_axes(const RigidPose& pose, const Vec3& point) {
  return rotation_matrix(pose.orientation).transpose() * (point - pose.position);
}

// (n) scalar potential of all bodies together at (n x 3) points [A], world axes; H is its descent.
Vector magnetic_potential(const Team& team, const std::vector<MagneticBody>& bodies,
                          const ConstPointsRef& points);

// Pose from a position [m] and a quaternion (w, x, y, z) of any length > 0.
RigidPose checked_pose(const Vec3& position, const Vec4& orientation);

// Meshes and lines are put about their own centre: of the volume, or the mean of the vertices.
MagneticBody make_mesh_magnet(const TriangleMesh& mesh, const Vec3& polarization);
MagneticBody make_polyline(Points vertices, double current);

}  // namespace loomstone
