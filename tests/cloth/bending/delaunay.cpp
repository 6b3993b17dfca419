#include "tests/cloth/bending/delaunay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

namespace loomstone::test {

namespace {

using Corners = std::array<Index, 3>;

double cross2(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

// Returns whether p is inside the circumcircle of the counter-clockwise triangle a, b, c.
bool in_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& p) {
  Mat3 m;
  for (const auto& [row, q] : {std::pair(0, a), std::pair(1, b), std::pair(2, c)}) {
    const Vec2 d = q - p;
    m.row(row) << d.x(), d.y(), d.squaredNorm();
  }
  return m.determinant() > 0.0;
}

}  // namespace

Triangles delaunay(const Points& points) {
  const Index n = static_cast<Index>(points.rows());
  std::vector<Vec2> p;
  for (Index i = 0; i < n; ++i) p.emplace_back(points(i, 0), points(i, 1));
  const Vec2 centre = points.leftCols<2>().colwise().mean().transpose();
  const double far = 1e5 * (points.colwise().maxCoeff() - points.colwise().minCoeff()).maxCoeff();
  for (const double angle : {0.3, 2.4, 4.5})
    p.push_back(centre + far * Vec2(std::cos(angle), std::sin(angle)));
  std::vector<Corners> triangles{{n, n + 1, n + 2}};
  for (Index i = 0; i < n; ++i) {
    // Directed edges of the triangles whose circumcircles contain point i. An edge between two such
    // triangles occurs in both directions.
    std::map<std::pair<Index, Index>, int> border;
    std::vector<Corners> kept;
    for (const Corners& t : triangles) {
      if (!in_circle(p[t[0]], p[t[1]], p[t[2]], p[i])) {
        kept.push_back(t);
        continue;
      }
      for (int k = 0; k < 3; ++k) ++border[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& [edge, count] : border)
      if (!border.count({edge.second, edge.first})) kept.push_back({edge.first, edge.second, i});
    triangles = std::move(kept);
  }
  std::vector<Corners> inside;
  for (const Corners& t : triangles)
    if (*std::max_element(t.begin(), t.end()) < n &&
        cross2(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]) > 0.0)
      inside.push_back(t);
  std::sort(inside.begin(), inside.end());
  Triangles result(inside.size(), 3);
  for (std::size_t t = 0; t < inside.size(); ++t)
    result.row(t) << inside[t][0], inside[t][1], inside[t][2];
  return result;
}

PointMesh random_mesh(double x0, double x1, double width, double h, unsigned seed, int smoothing) {
  std::vector<Vec3> points;
  const Index nx = static_cast<Index>(std::lround((x1 - x0) / h)),
              ny = static_cast<Index>(std::lround(width / h));
  std::mt19937 engine(seed);
  const auto random = [&] { return engine() / 4294967296.0; };
  for (Index i = 0; i <= nx; ++i)
    for (Index j = 0; j <= ny; ++j)
      if (i == 0 || j == 0 || i == nx || j == ny)
        points.emplace_back(x0 + i * (x1 - x0) / nx, j * width / ny, 0.0);
  const std::size_t n_border = points.size();
  // Each cell around an inner node contains one random point.
  for (Index i = 1; i < nx; ++i)
    for (Index j = 1; j < ny; ++j) {
      const double x = (i - 0.5 + random()) * (x1 - x0) / nx, y = (j - 0.5 + random()) * width / ny;
      points.emplace_back(x0 + x, y, 0.0);
    }
  PointMesh mesh;
  mesh.points.resize(points.size(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) mesh.points.row(i) = points[i].transpose();
  mesh.triangles = delaunay(mesh.points);
  for (int round = 0; round < smoothing; ++round) {
    Points sum = Points::Zero(mesh.points.rows(), 3);
    Vector count = Vector::Zero(mesh.points.rows());
    for (Index t = 0; t < mesh.triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k) {
        sum.row(mesh.triangles(t, k)) += mesh.points.row(mesh.triangles(t, (k + 1) % 3));
        ++count[mesh.triangles(t, k)];
      }
    for (Index i = n_border; i < mesh.points.rows(); ++i)
      mesh.points.row(i) = sum.row(i) / count[i];
    mesh.triangles = delaunay(mesh.points);
  }
  mesh.least_angle = M_PI;
  for (Index t = 0; t < mesh.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Vec3 at = mesh.points.row(mesh.triangles(t, k));
      const Vec3 a = mesh.points.row(mesh.triangles(t, (k + 1) % 3)).transpose() - at;
      const Vec3 b = mesh.points.row(mesh.triangles(t, (k + 2) % 3)).transpose() - at;
      mesh.least_angle = std::min(mesh.least_angle, std::atan2(a.cross(b).norm(), a.dot(b)));
    }
  return mesh;
}

}  // namespace loomstone::test
