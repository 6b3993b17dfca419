// Geometry of collision shapes: principal axes, checks of spheres and boxes, motion of triangles,
// and hulls shrunk by a margin.
#include "core/rigid/shape_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "core/base/message.h"

namespace loomstone {

void check_orientation(const Vec4& orientation, const std::string& where) {
  if (std::abs(orientation.norm() - 1.0) < 1e-6) return;
  fail<InvalidInput>(
      "{}.orientation must be a unit quaternion (w, x, y, z), got length {:.6g}; divide it by its "
      "length",
      where, orientation.norm());
}

Mat3 principal_axes(const Mat3& inertia) {
  const Mat3 off_diagonal = inertia - Mat3(inertia.diagonal().asDiagonal());
  if (off_diagonal.cwiseAbs().maxCoeff() < 1e-9 * inertia.trace()) return Mat3::Identity();
  Mat3 axes = Eigen::SelfAdjointEigenSolver<Mat3>(inertia).eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) = -axes.col(0);
  return axes;
}

Mat3 axes_from(const Vec3& first) {
  Mat3 axes;
  axes.col(0) = first;
  axes.col(1) = first.unitOrthogonal();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

std::vector<Vec3> body_points(const TriangleMesh& mesh, const Vec3& centre, const Mat3& principal) {
  std::vector<Vec3> points(mesh.n_vertices());
  for (Index i = 0; i < mesh.n_vertices(); ++i) {
    points[i] = principal.transpose() * (mesh.vertices().row(i).transpose() - centre);
  }
  return points;
}

double sphere_radius(const TriangleMesh& mesh, const MassProperties& mass,
                     const std::string& where) {
  const Vector distances = (mesh.vertices().rowwise() - mass.centre.transpose()).rowwise().norm();
  const double radius = distances.maxCoeff();
  // `filled` is 0.61 for an icosahedron, which is accepted, and 0.37 for a cube, which is rejected
  // although its corners lie on a sphere, too.
  const double filled = mass.volume / (4.0 / 3.0 * M_PI * radius * radius * radius);
  if (distances.minCoeff() < 0.99 * radius || filled < 0.5) {
    fail<InvalidInput>(
        "{}.shape \"sphere\" needs a mesh that is a sphere within 1 %, got vertices {:.6g} to "
        "{:.6g} m from the centre and {:.3g} % of the sphere's volume; use \"convex\" or another "
        "mesh",
        where, distances.minCoeff(), radius, 100.0 * filled);
  }
  return radius;
}

void check_box(const TriangleMesh& mesh, const std::string& where) {
  const Eigen::RowVector3d low = mesh.vertices().colwise().minCoeff(),
                           high = mesh.vertices().colwise().maxCoeff();
  for (int c = 0; c < 8; ++c) {
    const Eigen::RowVector3d corner(c & 1 ? high[0] : low[0], c & 2 ? high[1] : low[1],
                                    c & 4 ? high[2] : low[2]);
    const double distance = (mesh.vertices().rowwise() - corner).rowwise().norm().minCoeff();
    if (distance > 0.005 * (high - low).norm())
      fail<InvalidInput>(
          "{}.shape \"box\" needs a mesh that is a box within 1 %, with edges along the axes, got "
          "no vertex within {:.3g} m of the corner ({:.6g}, {:.6g}, {:.6g}); use \"convex\" or "
          "another mesh",
          where, distance, corner[0], corner[1], corner[2]);
  }
}

FacetMotion facet_motion(const Mat3& before, const Mat3& after, double step) {
  const Eigen::RowVector3d centre = before.colwise().mean();
  const Eigen::RowVector3d velocity = (after.colwise().mean() - centre) / step;
  Mat3 inertia = Mat3::Zero();
  Vec3 momentum = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec3 arm = (before.row(k) - centre).transpose();
    inertia += arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose();
    momentum += arm.cross(((after.row(k) - before.row(k)) / step - velocity).transpose());
  }
  return {velocity.transpose(), inertia.ldlt().solve(momentum)};
}

FacetFrame facet_frame(const Mat3& corners) {
  FacetFrame frame;
  frame.centre = corners.colwise().mean().transpose();
  const Vec3 edge = (corners.row(1) - corners.row(0)).transpose(),
             other = (corners.row(2) - corners.row(0)).transpose();
  frame.axes.col(0) = edge.normalized();
  frame.axes.col(2) = edge.cross(other).normalized();
  frame.axes.col(1) = frame.axes.col(2).cross(frame.axes.col(0));
  frame.corners = (corners.rowwise() - frame.centre.transpose()) * frame.axes;
  return frame;
}

ConvexCore convex_core(const std::vector<Vec3>& vertices,
                       const std::vector<std::vector<int>>& faces, double margin_share,
                       const std::string& where) {
  Vec3 centre = Vec3::Zero();
  for (const Vec3& vertex : vertices) centre += vertex / static_cast<double>(vertices.size());
  double size = 0.0;
  for (const Vec3& vertex : vertices) size = std::max(size, (vertex - centre).norm());

  // Area-weighted sums of n n^T and of the normals n over the faces at each vertex.
  std::vector<Mat3> products(vertices.size(), Mat3::Zero());
  std::vector<Vec3> sums(vertices.size(), Vec3::Zero());
  double inner_radius = size;
  for (const std::vector<int>& face : faces) {
    Vec3 area = Vec3::Zero();
    for (std::size_t k = 0; k < face.size(); ++k) {
      area +=
          0.5 * (vertices[face[k]] - centre).cross(vertices[face[(k + 1) % face.size()]] - centre);
    }
    if (area.norm() < 1e-12 * size * size) continue;  // skips slivers between coplanar points
    Vec3 normal = area.normalized();
    double distance = normal.dot(vertices[face[0]] - centre);
    if (distance < 0.0) normal = -normal, distance = -distance;
    inner_radius = std::min(inner_radius, distance);
    for (int corner : face) {
      products[corner] += area.norm() * normal * normal.transpose();
      sums[corner] += area.norm() * normal;
    }
  }
  if (vertices.size() < 4 || faces.size() < 4 || inner_radius <= 1e-6 * size) {
    fail<InvalidInput>(
        "{} must have a convex hull with volume, got points in one plane; give it a thickness",
        where);
  }

  // A vertex moves by -delta, where n . delta = margin for the normal n of each face at the vertex.
  // The solution is exact if at most three planes meet at the vertex, and otherwise an
  // area-weighted least-squares fit.
  ConvexCore core;
  core.margin = margin_share * inner_radius;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(products[i]);
    const Vec3& eigenvalues = solver.eigenvalues();
    Vec3 delta = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      // A vertex in the interior of an edge or a face does not move along this edge or face.
      if (eigenvalues[k] <= 1e-6 * eigenvalues[2]) continue;
      const Vec3 axis = solver.eigenvectors().col(k);
      delta += core.margin * axis.dot(sums[i]) / eigenvalues[k] * axis;
    }
    // Without this limit, a sharp corner could move beyond the centre.
    const double limit = 0.5 * (vertices[i] - centre).norm();
    if (delta.norm() > limit) delta *= limit / delta.norm();
    core.points.push_back(vertices[i] - delta);
  }
  return core;
}

void check_shape(const RigidBody& body, const std::string& where) {
  if (body.shape != BodyShape::Parts) return;
  if (body.parts.empty())
    fail<InvalidInput>(
        "{}.shape \"parts\" needs at least one convex mesh in parts, got none; use \"convex\" "
        "for one hull",
        where);
  for (std::size_t k = 0; k < body.parts.size(); ++k)
    if (!body.parts[k])
      fail<InvalidInput>("{}.parts[{}] must be a mesh, got none; give one", where, k);
}

}  // namespace loomstone
