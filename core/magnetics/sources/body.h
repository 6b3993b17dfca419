// Sources placed in the world, and the fields and potentials of sets of them.
#pragma once

#include <string>
#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/dipoles.h"

namespace loomstone {

class TriangleMesh;

struct MagneticBody {
  SourcePtr source;
  RigidPose pose;  // of the source's axes; their origin is the centre of the body

  Vec3 moment() const {
    return rotation_matrix(pose.orientation) * source->moment();
  }  // [A m^2], world axes
};

// (n x 3) B [T] or H [A/m] of all bodies together at (n x 3) points [m], world axes.
Points magnetic_field(const Team& team, const std::vector<MagneticBody>& bodies,
                      const ConstPointsRef& points, const std::string& quantity);
// (n x 9) dB_i/dx_j outside magnets [T/m], world axes.
Gradients magnetic_gradient(const Team& team, const std::vector<MagneticBody>& bodies,
                            const ConstPointsRef& points);

// B of one body and its gradient in one pass; the same bits as from the two functions above.
struct FieldAndGradient {
  Points field;        // (n x 3) [T]
  Gradients gradient;  // (n x 9) [T/m]
};
FieldAndGradient magnetic_field_and_gradient(const Team& team, const MagneticBody& body,
                                             const ConstPointsRef& points);

// The pose `of` expressed in the axes of the pose `in`.
inline RigidPose relative_pose(const RigidPose& of, const RigidPose& in) {
  return {rotation_matrix(in.orientation).transpose() * (of.position - in.position),
          quaternion_product(quaternion_inverse(in.orientation), of.orientation)};
}

// A world point in the axes of a pose.
inline Vec3 in_axes(const RigidPose& pose, const Vec3& point) {
  return rotation_matrix(pose.orientation).transpose() * (point - pose.position);
}

// (n) magnetic scalar potential of all bodies together at (n x 3) points [A]; H is minus its
// gradient.
Vector magnetic_potential(const Team& team, const std::vector<MagneticBody>& bodies,
                          const ConstPointsRef& points);

// Pose from a position [m] and a quaternion (w, x, y, z) of any length > 0, which is normalised.
// Throws InvalidInput.
RigidPose checked_pose(const Vec3& position, const Vec4& orientation);

// The centre of a mesh magnet is that of its volume, the centre of a polyline the mean of its
// vertices.
MagneticBody make_mesh_magnet(const TriangleMesh& mesh, const Vec3& polarization);
MagneticBody make_polyline(Points vertices, double current);

}  // namespace loomstone
