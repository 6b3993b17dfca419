#include "core/magnetics/sources/body.h"

#include <algorithm>

#include "core/base/message.h"
#include "core/base/simd.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/polyhedron.h"
#include "core/magnetics/sources/polyline.h"

namespace loomstone {

namespace {

// Points per task. The number is small for load balance: points near a body take much longer than
// others.
constexpr Index points_per_task = 32;

template <class Body>
void over_blocks(const Team& team, Index n, Body&& body) {
  parallel_tasks(team, (n + points_per_task - 1) / points_per_task, [&](Index task) {
    body(task * points_per_task, std::min(n, (task + 1) * points_per_task));
  });
}

// Transforms points to the body's axes and stores them in `columns` as coordinate arrays. The last
// point is repeated until the number of points is a multiple of n_lanes. Returns this number.
Index local_columns(const RigidPose& pose, const Mat3& rotation, const ConstPointsRef& points,
                    Index begin, Index end, double* columns) {
  const Index n = end - begin, padded = (n + n_lanes - 1) / n_lanes * n_lanes;
  const double* x = points.data() + 3 * static_cast<std::ptrdiff_t>(begin);
  for (Index i = 0; i < n; ++i) {
    const double d[3] = {x[3 * i] - pose.position[0], x[3 * i + 1] - pose.position[1],
                         x[3 * i + 2] - pose.position[2]};
    for (int k = 0; k < 3; ++k)
      columns[k * padded + i] =
          rotation(0, k) * d[0] + rotation(1, k) * d[1] + rotation(2, k) * d[2];
  }
  for (Index i = n; i < padded; ++i)
    for (int k = 0; k < 3; ++k) columns[k * padded + i] = columns[k * padded + n - 1];
  return padded;
}

std::vector<Mat3> rotations_of(const std::vector<MagneticBody>& bodies) {
  std::vector<Mat3> rotations;
  for (const MagneticBody& body : bodies)
    rotations.push_back(rotation_matrix(body.pose.orientation));
  return rotations;
}

// Rotates the field of a block to world axes and adds `scale` times the result to `rows`.
void add_field(const Mat3& r, const double* field, Index n, Index count, double scale,
               double* rows) {
  for (Index i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k)
      rows[3 * i + k] +=
          scale * (r(k, 0) * field[i] + r(k, 1) * field[n + i] + r(k, 2) * field[2 * n + i]);
}

void add_gradient(const Mat3& r, const double* g, Index n, Index count, double* rows) {
  for (Index i = 0; i < count; ++i) {
    Mat3 local;
    local << g[i], g[n + i], g[2 * n + i], g[n + i], g[3 * n + i], g[4 * n + i], g[2 * n + i],
        g[4 * n + i], g[5 * n + i];
    const Mat3 turned = r * local * r.transpose();
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l) rows[9 * i + 3 * k + l] += 0.5 * (turned(k, l) + turned(l, k));
  }
}

}  // namespace

Points magnetic_field(const Team& team, const std::vector<MagneticBody>& bodies,
                      const ConstPointsRef& points, const std::string& quantity) {
  if (quantity != "B" && quantity != "H")
    fail<InvalidInput>("quantity must be \"B\" or \"H\", got \"{}\"", quantity);
  check_points(points, "points");
  const Quantity wanted = quantity == "B" ? Quantity::flux_density : Quantity::mu0_field_strength;
  const double scale = quantity == "B" ? 1.0 : 1.0 / mu0;
  const std::vector<Mat3> rotations = rotations_of(bodies);
  Points result(points.rows(), 3);
  over_blocks(team, static_cast<Index>(points.rows()), [&](Index begin, Index end) {
    alignas(64) double columns[3 * points_per_block], field[3 * points_per_block];
    double* out = result.data() + 3 * static_cast<std::ptrdiff_t>(begin);
    std::fill_n(out, 3 * (end - begin), 0.0);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const Mat3& r = rotations[b];
      const Index n = local_columns(bodies[b].pose, r, points, begin, end, columns);
      bodies[b].source->field_block(columns, n, wanted, field);
      add_field(r, field, n, end - begin, scale, out);
    }
  });
  return result;
}

Gradients magnetic_gradient(const Team& team, const std::vector<MagneticBody>& bodies,
                            const ConstPointsRef& points) {
  check_points(points, "points");
  const std::vector<Mat3> rotations = rotations_of(bodies);
  Gradients result(points.rows(), 9);
  over_blocks(team, static_cast<Index>(points.rows()), [&](Index begin, Index end) {
    alignas(64) double columns[3 * points_per_block], g[6 * points_per_block];
    double* out = result.data() + 9 * static_cast<std::ptrdiff_t>(begin);
    std::fill_n(out, 9 * (end - begin), 0.0);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const Index n = local_columns(bodies[b].pose, rotations[b], points, begin, end, columns);
      bodies[b].source->gradient_block(columns, n, g);
      add_gradient(rotations[b], g, n, end - begin, out);
    }
  });
  return result;
}

FieldAndGradient magnetic_field_and_gradient(const Team& team, const MagneticBody& body,
                                             const ConstPointsRef& points) {
  check_points(points, "points");
  const Mat3 r = rotation_matrix(body.pose.orientation);
  FieldAndGradient result{Points::Zero(points.rows(), 3), Gradients::Zero(points.rows(), 9)};
  over_blocks(team, static_cast<Index>(points.rows()), [&](Index begin, Index end) {
    alignas(64) double columns[3 * points_per_block], field[3 * points_per_block],
        g[6 * points_per_block];
    const Index n = local_columns(body.pose, r, points, begin, end, columns);
    body.source->field_and_gradient_block(columns, n, Quantity::flux_density, field, g);
    add_field(r, field, n, end - begin, 1.0,
              result.field.data() + 3 * static_cast<std::ptrdiff_t>(begin));
    add_gradient(r, g, n, end - begin,
                 result.gradient.data() + 9 * static_cast<std::ptrdiff_t>(begin));
  });
  return result;
}

Vector magnetic_potential(const Team& team, const std::vector<MagneticBody>& bodies,
                          const ConstPointsRef& points) {
  check_points(points, "points");
  const std::vector<Mat3> rotations = rotations_of(bodies);
  Vector result = Vector::Zero(points.rows());
  over_blocks(team, static_cast<Index>(points.rows()), [&](Index begin, Index end) {
    alignas(64) double columns[3 * points_per_block], potential[points_per_block];
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const Index n = local_columns(bodies[b].pose, rotations[b], points, begin, end, columns);
      bodies[b].source->potential_block(columns, n, potential);
      for (Index i = 0; i < end - begin; ++i) result[begin + i] += potential[i] / mu0;
    }
  });
  return result;
}

RigidPose checked_pose(const Vec3& position, const Vec4& orientation) {
  if (!position.allFinite())
    throw InvalidInput("position must be finite [m], got a component that is not");
  if (!orientation.allFinite() || orientation.norm() == 0.0)
    throw InvalidInput("orientation must be a finite quaternion (w, x, y, z) other than zero");
  return {position, orientation.normalized()};
}

MagneticBody make_mesh_magnet(const TriangleMesh& mesh, const Vec3& polarization) {
  const Points& x = mesh.vertices();
  const Vec3 reference = x.colwise().mean().transpose();
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    Mat3 corners;
    for (int k = 0; k < 3; ++k)
      corners.col(k) = x.row(mesh.triangles()(t, k)).transpose() - reference;
    const double tetrahedron = corners.determinant() / 6.0;
    volume += tetrahedron;
    first += tetrahedron / 4.0 * corners.rowwise().sum();
  }
  const Vec3 centre = volume > 0.0 ? Vec3(reference + first / volume) : reference;
  return {std::make_shared<MeshMagnet>(mesh.moved(-centre), polarization),
          {centre, Vec4(1, 0, 0, 0)}};
}

MagneticBody make_polyline(Points vertices, double current) {
  check_points(vertices, "vertices");
  if (vertices.rows() == 0) throw InvalidInput("vertices must be at least two points, got 0");
  const Vec3 centre = vertices.colwise().mean().transpose();
  vertices.rowwise() -= centre.transpose();
  return {std::make_shared<Polyline>(std::move(vertices), current), {centre, Vec4(1, 0, 0, 0)}};
}

}  // namespace loomstone
