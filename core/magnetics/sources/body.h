// Magnetic bodies, which are sources at a pose, and their total field, gradient and potential.
#pragma once

#include <string>
#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/dipoles.h"

namespace loomstone {

class TriangleMesh;

struct MagneticBody {
  SourcePtr source;
  RigidPose pose;  // pose of the source's axes; torques are about `position` (the body's centre)

  // Returns the dipole moment in world axes [A m^2].
  Vec3 moment() const { return rotation_matrix(pose.orientation) * source->moment(); }
};

// Returns the total field of all bodies at points (n x 3) [m], in world axes (n x 3). `quantity` is
// "B" [T] or "H" [A/m].
Points magnetic_field(const Team& team, const std::vector<MagneticBody>& bodies,
                      const ConstPointsRef& points, const std::string& quantity);
// Returns the total field gradient dB_i/dx_j [T/m] of all bodies at points (n x 3) [m] outside the
// magnets, in world axes (n x 9).
Gradients magnetic_gradient(const Team& team, const std::vector<MagneticBody>& bodies,
                            const ConstPointsRef& points);

// B of one body and the gradient of B, computed in one pass. The values are bit-identical to those
// of magnetic_field() and magnetic_gradient().
struct FieldAndGradient {
  Points field;        // (n x 3) [T]
  Gradients gradient;  // (n x 9) [T/m]
};
FieldAndGradient magnetic_field_and_gradient(const Team& team, const MagneticBody& body,
                                             const ConstPointsRef& points);

// Returns the pose `of` expressed in the axes of the pose `in`.
inline RigidPose relative_pose(const RigidPose& of, const RigidPose& in) {
  return {rotation_matrix(in.orientation).transpose() * (of.position - in.position),
          quaternion_product(quaternion_inverse(in.orientation), of.orientation)};
}

// Transforms a world point to the axes of a pose.
inline Vec3 in_axes(const RigidPose& pose, const Vec3& point) {
  return rotation_matrix(pose.orientation).transpose() * (point - pose.position);
}

// Returns the total magnetic scalar potential [A] of all bodies at points (n x 3) [m]. H is its
// negative gradient. Throws Unsupported if a body is a current or an induced body.
Vector magnetic_potential(const Team& team, const std::vector<MagneticBody>& bodies,
                          const ConstPointsRef& points);

// Returns a pose with the given position [m] and quaternion (w, x, y, z). The quaternion may have
// any length > 0 and is normalised. Throws InvalidInput if a component is not finite or the
// quaternion is zero.
RigidPose checked_pose(const Vec3& position, const Vec4& orientation);

// make_mesh_magnet() and make_polyline() return a source and its pose in the frame of the mesh or
// of the vertices [m]. The axes of the source are parallel to those of this frame. The origin of
// the source is the centre of volume of the mesh, or the mean of the vertices. The polarization is
// in [T], the current in [A].
MagneticBody make_mesh_magnet(const TriangleMesh& mesh, const Vec3& polarization);
MagneticBody make_polyline(Points vertices, double current);

}  // namespace loomstone
