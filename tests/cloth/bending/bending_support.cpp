#include "tests/cloth/bending/bending_support.h"

#include <cmath>
#include <random>

#include <Eigen/SparseCholesky>

#include "core/mesh/generators.h"
#include "tests/cloth/bending/delaunay.h"

namespace loomstone::test {

Mat3 isotropic(double b, double nu) {
  Mat3 d;
  d << 1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 0.5 * (1.0 - nu);
  return b * d;
}

Mat3 some_rigidity() {
  Mat3 d;
  d << 1.0, 0.3, 0.1, 0.3, 4.0, -0.2, 0.1, -0.2, 0.8;
  return d;
}

BendingSetup flat_setup(const Points& vertices, const Triangles& triangles, const Mat3& rigidity,
                        double angle) {
  BendingSetup setup;
  setup.rest_positions = vertices;
  setup.triangles = triangles;
  const Eigen::Rotation2Dd to_material(-angle);
  for (Index t = 0; t < triangles.rows(); ++t) {
    Corners2 corners;
    for (int k = 0; k < 3; ++k)
      corners.row(k) =
          (to_material * Vec2(vertices(triangles(t, k), 0), vertices(triangles(t, k), 1)))
              .transpose();
    setup.corners.push_back(corners);
  }
  setup.rigidity.assign(triangles.rows(), rigidity);
  setup.damping.assign(triangles.rows(), 0.0);
  setup.prescribed.assign(vertices.rows(), 0);
  return setup;
}

BendingSetup flat_setup(const TriangleMesh& mesh, const Mat3& rigidity, double angle) {
  return flat_setup(mesh.vertices(), mesh.triangles(), rigidity, angle);
}

std::unique_ptr<Bending> make_bending(const std::string& element, const BendingSetup& setup) {
  return element == "hinge" ? make_hinge_bending(setup) : make_midedge_bending(setup);
}

Points noise(Index n, double size, unsigned seed) {
  std::mt19937 engine(seed);
  Points p(n, 3);
  for (Index i = 0; i < n; ++i)
    for (int d = 0; d < 3; ++d) p(i, d) = size * (2.0 * (engine() / 4294967295.0) - 1.0);
  return p;
}

namespace {

// Mesh of diamonds. Points (i, j) of a lattice, half a diagonal apart, are vertices for even i + j
// and centres of diamonds for odd i + j. Diamonds at the boundary are cut in half.
Strip diamond_strip(bool along, double length, double width, Index across) {
  const Index ny = 2 * across,
              nx = static_cast<Index>(std::lround(ny * length / width)) / 2 * 2 + 2, clamp = 2;
  const double half = width / ny, half_x = length / (nx - clamp);
  Strip strip{Points(), Triangles(), {}, {}, length};
  std::vector<Index> id((nx + 1) * (ny + 1), -1);
  std::vector<Vec3> points;
  for (Index i = 0; i <= nx; ++i)
    for (Index j = 0; j <= ny; ++j) {
      if ((i + j) % 2) continue;
      id[i * (ny + 1) + j] = static_cast<Index>(points.size());
      points.emplace_back((i - clamp) * half_x, j * half, 0.0);
      strip.prescribed.push_back(i <= clamp);
      if (i == nx) strip.tip.push_back(id[i * (ny + 1) + j]);
    }
  std::vector<std::array<Index, 3>> triangles;
  for (Index i = 0; i <= nx; ++i)
    for (Index j = 0; j <= ny; ++j) {
      if ((i + j) % 2 == 0) continue;
      const auto at = [&](Index a, Index b) {
        return a < 0 || a > nx || b < 0 || b > ny ? -1 : id[a * (ny + 1) + b];
      };
      const Index w = at(i - 1, j), e = at(i + 1, j), s = at(i, j - 1), n = at(i, j + 1);
      const bool whole = w >= 0 && e >= 0 && s >= 0 && n >= 0;
      if (n < 0 || s < 0 || (whole && along && i != clamp)) {  // w-e divides or bounds the diamond
        if (n >= 0) triangles.push_back({w, e, n});
        if (s >= 0) triangles.push_back({w, s, e});
      } else {  // s-n divides or bounds the diamond; for i = clamp, it lies on the clamp line
        if (e >= 0) triangles.push_back({s, e, n});
        if (w >= 0) triangles.push_back({s, n, w});
      }
    }
  strip.vertices.resize(points.size(), 3);
  for (std::size_t k = 0; k < points.size(); ++k) strip.vertices.row(k) = points[k].transpose();
  strip.triangles.resize(triangles.size(), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    strip.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
  return strip;
}

}  // namespace

Strip make_strip(const std::string& pattern, double length, double width, Index across) {
  if (pattern == "along" || pattern == "across")
    return diamond_strip(pattern == "along", length, width, across);
  const double h = width / across;
  const Index nx = static_cast<Index>(std::lround(length / h));
  const TriangleMesh mesh =
      grid_cells(length + length / nx, width, nx + 1, across,
                 pattern == "diagonal" || pattern == "mirrored" ? "diagonal" : "alternating");
  Strip strip{mesh.vertices(),
              mesh.triangles(),
              std::vector<std::uint8_t>(mesh.n_vertices(), 0),
              {},
              length};
  const Points shift = pattern == "jittered" ? noise(mesh.n_vertices(), 0.3 * h, 7)
                                             : Points::Zero(mesh.n_vertices(), 3);
  for (Index i = 0; i < mesh.n_vertices(); ++i) {
    const Index column = i % (nx + 2), row = i / (nx + 2);
    strip.vertices(i, 0) = (column - 1) * length / nx;
    strip.vertices(i, 1) = row * h;
    if (column <= 1) strip.prescribed[i] = 1;
    if (column == nx + 1) strip.tip.push_back(i);
    if (column > 1 && column <= nx && row > 0 && row < across)
      strip.vertices.block<1, 2>(i, 0) += shift.block<1, 2>(i, 0);
    if (pattern == "mirrored") strip.vertices(i, 1) = width - row * h;
  }
  if (pattern == "mirrored") strip.triangles.col(1).swap(strip.triangles.col(2));
  return strip;
}

Vector lumped_areas(const Points& vertices, const Triangles& triangles) {
  Vector area = Vector::Zero(vertices.rows());
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Vec3 a = vertices.row(triangles(t, 0)), b = vertices.row(triangles(t, 1)),
               c = vertices.row(triangles(t, 2));
    for (int k = 0; k < 3; ++k) area[triangles(t, k)] += (b - a).cross(c - a).norm() / 6.0;
  }
  return area;
}

Strip random_strip(double length, double width, Index across, unsigned seed, int smoothing,
                   double* least_angle) {
  const double h = width / across;
  const PointMesh mesh = random_mesh(0.0, length, width, h, seed, smoothing);
  if (least_angle) *least_angle = mesh.least_angle;
  // A column of prescribed cells behind the clamp line clamps the slope, because it turns the edges
  // on this line into hinges.
  const Index n = static_cast<Index>(mesh.points.rows()),
              m = static_cast<Index>(mesh.triangles.rows());
  Strip strip{Points(n + across + 1, 3),
              Triangles(m + 2 * across, 3),
              std::vector<std::uint8_t>(n + across + 1, 0),
              {},
              length};
  strip.vertices.topRows(n) = mesh.points;
  strip.triangles.topRows(m) = mesh.triangles;
  std::vector<Index> at_clamp(across + 1);
  for (Index i = 0; i < n; ++i) {
    if (mesh.points(i, 0) == length) strip.tip.push_back(i);
    if (mesh.points(i, 0) != 0.0) continue;
    at_clamp[std::lround(mesh.points(i, 1) / h)] = i;
    strip.prescribed[i] = 1;
  }
  for (Index j = 0; j <= across; ++j) {
    strip.vertices.row(n + j) << -h, j * h, 0.0;
    strip.prescribed[n + j] = 1;
    if (j == across) break;
    strip.triangles.row(m + 2 * j) << n + j, at_clamp[j], at_clamp[j + 1];
    strip.triangles.row(m + 2 * j + 1) << n + j, at_clamp[j + 1], n + j + 1;
  }
  return strip;
}

Vector deflections(const Points& vertices, const Triangles& triangles,
                   const std::vector<std::uint8_t>& prescribed, const Bending& bending) {
  const Index n = static_cast<Index>(vertices.rows());
  BlockMatrix k(n, bending.couplings());
  bending.add_stiffness(Team{}, vertices, {1.0, 0.0}, 0, n, k);
  std::vector<Index> unknown(n, -1);
  Index n_free = 0;
  for (Index i = 0; i < n; ++i)
    if (!prescribed[i]) unknown[i] = n_free++;
  // Bending forces of a flat sheet act along z only.
  std::vector<Eigen::Triplet<double>> entries;
  for (Index i = 0; i < n; ++i)
    for (Index p = k.row_start()[i]; p < k.row_start()[i + 1]; ++p)
      if (unknown[i] >= 0 && unknown[k.columns()[p]] >= 0)
        entries.emplace_back(unknown[i], unknown[k.columns()[p]], k.block_map(p)(2, 2));
  Eigen::SparseMatrix<double> matrix(n_free, n_free);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Vector load = lumped_areas(vertices, triangles);
  Vector b(n_free);
  for (Index i = 0; i < n; ++i)
    if (unknown[i] >= 0) b[unknown[i]] = load[i];
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  const Vector solved = solver.solve(b);
  Vector z = Vector::Zero(n);
  for (Index i = 0; i < n; ++i)
    if (unknown[i] >= 0) z[i] = solved[unknown[i]];
  return z;
}

double tip_deflection(const Strip& strip, const Bending& bending) {
  const Vector z = deflections(strip.vertices, strip.triangles, strip.prescribed, bending);
  double sum = 0.0;
  for (const Index i : strip.tip) sum += z[i];
  return sum / static_cast<double>(strip.tip.size());
}

}  // namespace loomstone::test
