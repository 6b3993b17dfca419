#include "renderer/tubes.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace loomstone {
namespace {

// Number of sides of a tube. The normals of neighbouring sides differ by 36 degrees, less than the
// crease angle of drawn_bodies() (40 degrees), so tubes look smooth.
constexpr Index sides = 10;

Vec3 any_normal(const Vec3& tangent) {
  const Vec3 aside = std::abs(tangent.x()) < 0.8 ? Vec3::UnitX() : Vec3::UnitY();
  return tangent.cross(aside).normalized();
}

void check(const Curves& curves) {
  if (!curves.points.allFinite() || !(curves.radius > 0.0))
    throw InvalidInput("curves must have finite points and a radius > 0 [m]");
  if (curves.first.empty() || curves.first.front() != 0 ||
      curves.first.back() != curves.points.rows() || !std::ranges::is_sorted(curves.first) ||
      curves.value.size() != curves.points.rows())
    throw InvalidInput(
        "curves.first must ascend from 0 to the number of points, with a value for each");
}

}  // namespace

BodiesAndTubes bodies_and_tubes(const FrameTopology& bodies, const Points& first_bodies,
                                const Points& body_vertices, const Curves& curves) {
  check(curves);
  const Index n_bodies = static_cast<Index>(body_vertices.rows()),
              n_points = static_cast<Index>(curves.points.rows());
  BodiesAndTubes all;
  FrameTopology topology = bodies;
  all.positions.resize(n_bodies + sides * n_points, 3);
  all.positions.topRows(n_bodies) = body_vertices;
  all.values = Vector::Zero(all.positions.rows());
  if (!bodies.body_pole.empty())
    all.values.head(n_bodies) = Eigen::Map<const Vector>(bodies.body_pole.data(), n_bodies);
  const Index tube = static_cast<Index>(topology.body_names.size());
  topology.body_names.push_back("curves");
  topology.body_is_floor.push_back(0);
  topology.body_of_vertex.resize(all.positions.rows(), tube);

  std::vector<std::array<Index, 3>> triangles;
  for (std::size_t c = 0; c + 1 < curves.first.size(); ++c) {
    const Index begin = curves.first[c], end = curves.first[c + 1];
    Vec3 normal = Vec3::Zero();  // transported along the curve without twist (parallel transport)
    for (Index i = begin; i < end; ++i) {
      Vec3 tangent =
          (curves.points.row(std::min(i + 1, end - 1)) - curves.points.row(std::max(i - 1, begin)))
              .transpose();
      tangent = tangent.norm() > 0.0 ? tangent.normalized() : Vec3::UnitZ();
      normal -= normal.dot(tangent) * tangent;
      normal = normal.norm() > 1e-6 ? normal.normalized() : any_normal(tangent);
      const Vec3 other = tangent.cross(normal);
      for (Index s = 0; s < sides; ++s) {
        const double angle = 2.0 * 3.14159265358979323846 * s / sides;
        const Index row = n_bodies + sides * i + s;
        all.positions.row(row) =
            curves.points.row(i) +
            curves.radius * (std::cos(angle) * normal + std::sin(angle) * other).transpose();
        all.values[row] = curves.value[i];
        if (i + 1 == end) continue;
        const Index next = n_bodies + sides * i + (s + 1) % sides;
        triangles.push_back({row, next, next + sides});
        triangles.push_back({row, next + sides, row + sides});
      }
    }
  }
  const Index m = static_cast<Index>(topology.body_triangles.rows());
  topology.body_triangles.conservativeResize(m + static_cast<Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      topology.body_triangles(m + static_cast<Index>(t), k) = triangles[t][k];
  topology.body_of_triangle.resize(topology.body_triangles.rows(), tube);
  if (bodies.body_corner_uv.rows() > 0) {
    topology.body_corner_uv = Points2::Zero(topology.body_triangles.size(), 2);
    topology.body_corner_uv.topRows(bodies.body_corner_uv.rows()) = bodies.body_corner_uv;
  }
  Points shape = all.positions;
  shape.topRows(n_bodies) = first_bodies;
  all.mesh = drawn_bodies(topology, shape);
  return all;
}

}  // namespace loomstone
