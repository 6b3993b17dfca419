// Geometry of collision shapes, independent of Bullet.
#pragma once

#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// Throws InvalidInput unless the quaternion has unit length within 1e-6.
void check_orientation(const Vec4& orientation, const std::string& where);

// Returns the principal axes of inertia in mesh axes (columns). If the inertia is already diagonal,
// these are the mesh axes.
Mat3 principal_axes(const Mat3& inertia);
// Returns a right-handed orthonormal frame whose first column is the unit vector `first`.
Mat3 axes_from(const Vec3& first);

// Returns the vertices relative to the centre of mass [m], in the axes that are the columns of
// `principal`: the principal axes or, for a body in a bearing, axes_from() its axis.
std::vector<Vec3> body_points(const TriangleMesh& mesh, const Vec3& centre, const Mat3& principal);

// Throws InvalidInput unless the mesh has a vertex at each corner of its bounding box, within 1 %
// of half the diagonal of the box.
void check_box(const TriangleMesh& mesh, const std::string& where);
// Returns the radius of a spherical mesh [m]: the largest distance of a vertex from the centre of
// mass. Throws InvalidInput unless all vertices lie on the sphere within 1 % of the radius and the
// mesh fills at least half of the sphere.
double sphere_radius(const TriangleMesh& mesh, const MassProperties& mass,
                     const std::string& where);

// The best-fit rigid motion (velocity [m/s], angular velocity [rad/s]) of a triangle that moves
// from `before` to `after` (rows: corners) in `step` [s].
struct FacetMotion {
  Vec3 velocity, angular_velocity;
};
FacetMotion facet_motion(const Mat3& before, const Mat3& after, double step);

// Centroid of a triangle [m], its axes (columns: unit vectors along the first edge, perpendicular
// to it in the plane, and along the normal), and its corners (rows) relative to the centroid, in
// these axes [m].
struct FacetFrame {
  Vec3 centre;
  Mat3 axes, corners;
};
FacetFrame facet_frame(const Mat3& corners);

// A convex polyhedron that is shrunk by about `margin`. The points within `margin` of the shrunken
// polyhedron nearly form the original one, with rounded edges.
struct ConvexCore {
  std::vector<Vec3> points;
  double margin = 0.0;  // [m]
};
// `faces` lists the corners of each face of the hull in cyclic order. `margin_share` is the ratio
// of the margin to the inner radius. The inner radius is the smallest distance from the mean of the
// vertices to a face. Throws InvalidInput for flat hulls.
ConvexCore convex_core(const std::vector<Vec3>& vertices,
                       const std::vector<std::vector<int>>& faces, double margin_share,
                       const std::string& where);

// The separating-axis test and face clipping find two kinds of contacts: those between two hulls
// with at most most_polyhedron_vertices vertices each, and those between triangles of obstacles and
// a hull with at most most_vertices_on_triangles vertices. The cost of the test grows with the
// product of the face counts. Hulls with more than most_polyhedron_vertices vertices count as
// round. All other contacts of hulls come from Bullet's method, which accumulates contact points
// over several steps.
constexpr int most_polyhedron_vertices = 32, most_vertices_on_triangles = 512;
// Ratio of the margin to the inner radius. Polyhedra need a margin only in contact with shapes that
// are neither polyhedra nor triangles. Round hulls need a margin so large that their shrunken cores
// seldom overlap. If cores overlap, Bullet runs a slow penetration search.
constexpr double polyhedron_margin = 1e-4, round_margin = 0.05;

// Throws InvalidInput if the shape is Parts but `parts` is empty or contains a null mesh.
void check_shape(const RigidBody& body, const std::string& where);

}  // namespace loomstone
