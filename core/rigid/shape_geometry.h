// Geometry of collision shapes, independent of Bullet.
#pragma once

#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// Throws InvalidInput unless the quaternion has unit length.
void check_orientation(const Vec4& orientation, const std::string& where);

// Principal axes in mesh axes (columns). Aligned meshes, and those with equal moments, keep their
// own axes.
Mat3 principal_axes(const Mat3& inertia);

// Vertices in principal axes relative to the centre of mass [m].
std::vector<Vec3> body_points(const TriangleMesh& mesh, const Vec3& centre, const Mat3& principal);

// Radius about the centre of mass [m]; throws InvalidInput unless the mesh is a sphere within 1 %.
double sphere_radius(const TriangleMesh& mesh, const MassProperties& mass, double density,
                     const std::string& where);

// The best-fit rigid motion (velocity [m/s], angular velocity [rad/s]) of a triangle that moves
// from `before` to `after` (rows: corners) in `step` [s].
struct FacetMotion {
  Vec3 velocity, angular_velocity;
};
FacetMotion facet_motion(const Mat3& before, const Mat3& after, double step);

// Centre of a triangle, its axes (columns: along the first edge, across, normal), and its corners
// in these axes.
struct FacetFrame {
  Vec3 centre;
  Mat3 axes, corners;
};
FacetFrame facet_frame(const Mat3& corners);

// A convex polyhedron, shrunk so that the core enlarged by `margin` fills it except at its rounded
// edges.
struct ConvexCore {
  std::vector<Vec3> points;
  double margin = 0.0;  // [m]
};
// faces: corners of each face of the hull in cyclic order; margin_share: margin over inner radius
// [1]. Throws InvalidInput for flat hulls.
ConvexCore convex_core(const std::vector<Vec3>& vertices,
                       const std::vector<std::vector<int>>& faces, double margin_share,
                       const std::string& where);

// Contacts of hulls with few vertices, among themselves and with triangles of obstacles, come from
// separating axes and clipped faces. Stacks of five cubes then come to rest; with contact points
// accumulated over several steps they jitter at 2 cm/s and creep by 0.6 mm. The cost grows with
// faces times faces, and hulls with more vertices than this are round enough without. Our choice.
constexpr int most_polyhedron_vertices = 32;
// Margin over inner radius. Polyhedra need a margin only in contact with other shapes. Round hulls
// need one that avoids Bullet's slower and rougher search for penetrations; stacks behave alike
// from 0.01 to 0.15.
constexpr double polyhedron_margin = 1e-4, round_margin = 0.05;

// Throws InvalidInput for unknown shapes and for parts without a mesh.
void check_shape(const RigidBody& body, const std::string& where);

}  // namespace loomstone
