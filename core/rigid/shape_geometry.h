// Geometry of collision shapes, before any engine sees them.
#pragma once

#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// Throws InvalidInput unless the quaternion has unit length.
void check_orientation(const Vec4& orientation, const std::string& where);

// Columns: principal axes in mesh axes. Meshes already aligned (and those of equal moments) keep their own axes.
Mat3 principal_axes(const Mat3& inertia);

// Vertices in principal axes relative to the centre of mass [m].
std::vector<Vec3> body_points(const TriangleMesh& mesh, const Vec3& centre, const Mat3& principal);

// Radius about the centre of mass [m]; throws InvalidInput where the mesh is no sphere to 1 %.
double sphere_radius(const TriangleMesh& mesh, const MassProperties& mass, double density, const std::string& where);

// A convex polyhedron shrunk so that core plus a ball of radius `margin` fills it again but for rounded edges.
struct ConvexCore {
  std::vector<Vec3> points;
  double margin = 0.0;  // [m]
};
// `faces`: corners of each face of the hull, in order round it. `margin_share`: margin over inner radius [1]. Throws
// InvalidInput when flat.
ConvexCore convex_core(const std::vector<Vec3>& vertices, const std::vector<std::vector<int>>& faces,
                       double margin_share, const std::string& where);

}  // namespace loomstone
