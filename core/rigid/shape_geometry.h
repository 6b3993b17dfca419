// Geometry of collision shapes, before any engine sees them.
#pragma once

#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// Throws InvalidInput unless the quaternion has unit length.
void check_orientation(const Vec4& orientation, const std::string& where);

// Columns: principal axes in mesh axes. Meshes already aligned (and those of equal moments) keep
// their own axes.
Mat3 principal_axes(const Mat3& inertia);

// Vertices in principal axes relative to the centre of mass [m].
std::vector<Vec3> body_points(const TriangleMesh& mesh, const Vec3& centre, const Mat3& principal);

// Radius about the centre of mass [m]; throws InvalidInput where the mesh is no sphere to 1 %.
double sphere_radius(const TriangleMesh& mesh, const MassProperties& mass, double density,
                     const std::string& where);

// The rigid motion nearest to that of a triangle (rows: corners) [m/s, rad/s]; stretching is left
// out.
struct FacetMotion {
  Vec3 velocity, angular_velocity;
};
FacetMotion facet_motion(const Mat3& before, const Mat3& after, double step);

// Centre of a triangle, axes (columns: along its first edge, across, normal), and its corners in
// them.
struct FacetFrame {
  Vec3 centre;
  Mat3 axes, corners;
};
FacetFrame facet_frame(const Mat3& corners);

// A convex polyhedron shrunk so that core plus a ball of radius `margin` fills it again but for
// rounded edges.
struct ConvexCore {
  std::vector<Vec3> points;
  double margin = 0.0;  // [m]
};
// `faces`: corners of each face of the hull, in order round it. `margin_share`: margin over inner
// radius [1]. Throws InvalidInput when flat.
ConvexCore convex_core(const std::vector<Vec3>& vertices,
                       const std::vector<std::vector<int>>& faces, double margin_share,
                       const std::string& where);

// Hulls of few vertices meet one another, and triangles of obstacles, by separating axes and
// clipped faces: then stacks of five cubes come to rest, where points gathered over several steps
// let them jitter at 2 cm/s and creep by 0.6 mm. The cost grows with faces times faces: above this
// number of vertices a hull is round enough to do without. Our choice.
constexpr int most_polyhedron_vertices = 32;
// Margin over inner radius. Polyhedra need none but in contact with others; round hulls need one
// that keeps them out of Bullet's slower and rougher search for penetrations (0.01 to 0.15 make no
// difference to stacks).
constexpr double polyhedron_margin = 1e-4, round_margin = 0.05;

// Throws InvalidInput unless the shape is one of those known, and parts are meshes.
void check_shape(const RigidBody& body, const std::string& where);

}  // namespace loomstone
