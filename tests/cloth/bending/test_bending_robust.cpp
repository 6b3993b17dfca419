// Tests of bending: threads and row ranges, folds, slivers, triangles without area, curvatures of
// quadratic surfaces, and invalid input.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>

#include "core/base/error.h"
#include "core/cloth/bending/bending_setup.h"
#include "core/cloth/bending/midedge_setup.h"
#include "core/mesh/generators.h"
#include "tests/cloth/bending/bending_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

bool same_bits(const double* a, const double* b, std::size_t n) {
  return std::memcmp(a, b, 8 * n) == 0;
}
bool same_bits(const Points& a, const Points& b) { return same_bits(a.data(), b.data(), a.size()); }
bool same_bits(const BlockMatrix& a, const BlockMatrix& b) {
  return same_bits(a.block(0), b.block(0), 9 * a.n_blocks());
}

}  // namespace

TEST_CASE(
    "bending forces and stiffness have the same bits on 1, 2, 3 and 7 threads and in any split of "
    "the rows") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 40, 40);
  BendingSetup setup = flat_setup(mesh, some_rigidity());
  setup.damping.assign(mesh.n_triangles(), 1e-2);
  const auto bending = make_bending(element, setup);
  const Index n = mesh.n_vertices();
  const Points x = mesh.vertices() + noise(n, 0.01, 1), v = noise(n, 1.0, 2);
  Points expected = Points::Zero(n, 3);
  BlockMatrix k(n, bending->couplings());
  bending->add_forces(Team{1}, x, v, 0, n, expected);
  bending->add_stiffness(Team{1}, x, {0.5, 0.25}, 0, n, k);
  const double energy = bending->energy(Team{1}, x);
  const BlockMatrix empty(n, bending->couplings());
  for (const int threads : {1, 2, 3, 7}) {
    CAPTURE(threads);
    Points force = Points::Zero(n, 3);
    BlockMatrix matrix = empty;
    // Assembles with a new element object in three ranges of rows.
    const auto again = make_bending(element, setup);
    const Index cuts[4] = {0, 700, 1408, n};
    for (int r = 0; r < 3; ++r) {
      again->add_forces(Team{threads}, x, v, cuts[r], cuts[r + 1], force);
      again->add_stiffness(Team{threads}, x, {0.5, 0.25}, cuts[r], cuts[r + 1], matrix);
    }
    CHECK(same_bits(force, expected));
    CHECK(same_bits(matrix, k));
    force.setZero();
    matrix.set_zero();
    bending->add_forces(Team{threads}, x, v, 0, n, force);
    bending->add_stiffness(Team{threads}, x, {0.5, 0.25}, 0, n, matrix);
    CHECK(same_bits(force, expected));
    CHECK(same_bits(matrix, k));
    CHECK(bending->energy(Team{threads}, x) == energy);
  }
}

TEST_CASE("a completely closed fold gives only finite numbers") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 4, 4);
  const auto bending = make_bending(element, flat_setup(mesh, isotropic(1.0, 0.3)));
  const Index n = mesh.n_vertices();
  double before = 0.0;
  for (const double angle : {0.5, 1.0, 1.6, 2.5, 3.0, M_PI}) {
    CAPTURE(angle);
    Points x = mesh.vertices();
    for (Index i = 0; i < n; ++i)
      if (x(i, 0) > 0.0) x.row(i) << x(i, 0) * std::cos(angle), x(i, 1), x(i, 0) * std::sin(angle);
    Points force = Points::Zero(n, 3);
    bending->add_forces(Team{}, x, Points::Zero(n, 3), 0, n, force);
    CHECK(force.allFinite());
    const double energy = bending->energy(Team{}, x);
    CHECK(energy > before);
    before = energy;
  }
}

TEST_CASE("a fold that passes through itself comes back from the other side") {
  // Angles are not continued beyond pi, where the two triangles have passed through each other.
  // Collision handling prevents such folds. Without it, the cloth then unfolds in the shorter
  // direction, because the energy depends only on the current shape.
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  Points x(4, 3);
  x << 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, -0.5, 0.0, 0.0, 0.5, 0.0, 0.0;
  Triangles triangles(2, 3);
  triangles << 0, 2, 3, 1, 3, 2;
  const auto bending = make_bending(element, flat_setup(x, triangles, isotropic(1.0, 0.0)));
  const auto folded = [&](double angle) {
    Points at = x;
    at.row(0) << 0.0, std::cos(angle), std::sin(angle);
    return at;
  };
  // Torque about the fold on the triangle of vertex 0 [N m], positive towards larger angles.
  const auto opening = [&](double angle) {
    Points force = Points::Zero(4, 3);
    bending->add_forces(Team{}, folded(angle), Points::Zero(4, 3), 0, 4, force);
    return force.row(0).dot(Eigen::RowVector3d(0.0, -std::sin(angle), std::cos(angle)));
  };
  for (const double beyond : {1e-3, 0.2, 0.5}) {
    CAPTURE(beyond);
    CHECK(bending->energy(Team{}, folded(M_PI + beyond)) ==
          Approx(bending->energy(Team{}, folded(M_PI - beyond))).epsilon(1e-9));
    CHECK(opening(M_PI - beyond) < 0.0);
    CHECK(opening(M_PI + beyond) == Approx(-opening(M_PI - beyond)).epsilon(1e-9));
    CHECK(bending->energy(Team{}, folded(M_PI + beyond)) < bending->energy(Team{}, folded(M_PI)));
  }
}

TEST_CASE("hinges of a triangle without area exert no force and are counted") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 4, 4);
  BendingSetup setup = flat_setup(mesh, isotropic(1.0, 0.3));
  setup.damping.assign(mesh.n_triangles(), 1e-2);
  const auto bending = make_bending(element, setup);
  const Index n = mesh.n_vertices();
  CHECK(bending->degenerate_hinges(Team{}, mesh.vertices()) == 0);
  Points x = mesh.vertices();
  x.row(mesh.triangles()(0, 0)) = x.row(mesh.triangles()(0, 1));  // one edge collapses
  CHECK(bending->degenerate_hinges(Team{}, x) > 0);
  CHECK(bending->degenerate_hinges(Team{}, Points::Zero(n, 3)) ==
        static_cast<Index>(bending->hinges().size()));
  for (const Points& shape : {x, Points(Points::Zero(n, 3))}) {
    Points force = Points::Zero(n, 3);
    bending->add_forces(Team{}, shape, noise(n, 1.0, 1), 0, n, force);
    CHECK(force.allFinite());
    CHECK(std::isfinite(bending->energy(Team{}, shape)));
    BlockMatrix k(n, bending->couplings());
    bending->add_stiffness(Team{}, shape, {1.0, 1.0}, 0, n, k);
    CHECK(std::all_of(k.block(0), k.block(0) + 9 * k.n_blocks(),
                      [](double a) { return std::isfinite(a); }));
  }
}

TEST_CASE("a single triangle does not bend") {
  const std::string element = GENERATE("hinge", "midedge");
  Points x(3, 3);
  x << 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
  Triangles triangles(1, 3);
  triangles << 0, 1, 2;
  const auto bending = make_bending(element, flat_setup(x, triangles, isotropic(1.0, 0.0)));
  Points force = Points::Zero(3, 3);
  bending->add_forces(Team{}, x, x, 0, 3, force);
  BlockMatrix k(3, bending->couplings());
  bending->add_stiffness(Team{}, x, {1.0, 1.0}, 0, 3, k);
  CHECK(force.norm() == 0.0);
  CHECK(bending->energy(Team{}, x) == 0.0);
  CHECK(bending->couplings().empty());
  CHECK(bending->largest_eigenvalue(Vector::Ones(3)) == 0.0);
}

TEST_CASE(
    "every quadratic surface has its exact curvature in interior triangles of the mid-edge "
    "element") {
  const std::string pattern = GENERATE("alternating", "diagonal", "jittered", "along", "across");
  CAPTURE(pattern);
  const Strip strip = make_strip(pattern, 1.0, 1.0, 7);
  const BendingSetup setup = flat_setup(strip.vertices, strip.triangles, some_rigidity());
  const EdgeTable edges = edge_table(static_cast<Index>(strip.vertices.rows()), strip.triangles);
  const HingeSet set = make_hinge_set(setup, edges);
  const midedge::Elements made = midedge::make_elements(setup, edges, set.hinges());
  CHECK(made.n_averaged == 0);
  // A triangle is interior if neither it nor a neighbour has a boundary edge.
  const Index m = static_cast<Index>(strip.triangles.rows());
  std::vector<bool> edge_of_mesh(m, false);
  for (Index t = 0; t < m; ++t)
    for (const Index e : edges.of_triangle[t])
      edge_of_mesh[t] = edge_of_mesh[t] || edges.triangles[e][1] < 0;
  const double small = 1e-6;  // curvatures [1/m] so small that angles are linear in z
  double sign = 0.0;
  int n_interior = 0;
  for (const Vec3& kappa :
       {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.5, 0.5, 1), Vec3(0, 0, 2), Vec3(0.25, 0.75, 0.87)}) {
    Points x = strip.vertices;
    for (Index i = 0; i < x.rows(); ++i)
      x(i, 2) = 0.5 * small *
                (kappa[0] * x(i, 0) * x(i, 0) + kappa[1] * x(i, 1) * x(i, 1) +
                 kappa[2] * x(i, 0) * x(i, 1));
    const std::vector<double> angles = measure_angles(set.hinges(), x);
    for (Index t = 0; t < m; ++t) {
      bool interior = !edge_of_mesh[t];
      for (const Index e : edges.of_triangle[t])
        for (const Index other : edges.triangles[e])
          interior = interior && other >= 0 && !edge_of_mesh[other];
      if (!interior) continue;
      ++n_interior;
      Vec3 found = Vec3::Zero();
      const midedge::Element& element = made.elements[t];
      for (int s = 0; s < element.n_hinges; ++s)
        found += element.curvature[s] * angles[element.hinge[s]] / small;
      if (sign == 0.0) sign = found.dot(kappa) > 0.0 ? 1.0 : -1.0;  // the sign is a convention
      CHECK((sign * found - kappa).norm() < 1e-8 * kappa.norm());
    }
  }
  CHECK(n_interior > 50);
}

TEST_CASE(
    "slivers fall back to the mean slope, are counted, and keep the highest frequency within its "
    "bound") {
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 3, 3, "diagonal");
  const Mat3 rigidity = isotropic(1.0, 0.0);  // its largest eigenvalue is 1
  Index n_averaged = 0, n_valid = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    Points x = mesh.vertices();
    // The noise can invert triangles; meshes with inverted or nearly flat triangles are skipped
    // below.
    x.leftCols<2>() += noise(mesh.n_vertices(), 0.7 / 3.0, seed).leftCols<2>();
    double least_height = 1.0;
    for (Index t = 0; t < mesh.n_triangles(); ++t) {
      const Vec3 a = x.row(mesh.triangles()(t, 0)), b = x.row(mesh.triangles()(t, 1)),
                 c = x.row(mesh.triangles()(t, 2));
      const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
      least_height = std::min(least_height, (b - a).cross(c - a).z() / longest);
    }
    if (least_height <= 1e-4) continue;
    ++n_valid;
    const auto bending = make_midedge_bending(flat_setup(x, mesh.triangles(), rigidity));
    n_averaged += bending->averaged_edges();
    // The bound is for unit rigidity and density. Its factor of 16 is empirical.
    CHECK(bending->largest_eigenvalue(lumped_areas(x, mesh.triangles())) <=
          16.0 / std::pow(least_height, 4));
  }
  CHECK(n_valid > 20);
  CHECK(n_averaged > 0);
  // No edge of a regular mesh uses the mean slope.
  CHECK(make_midedge_bending(flat_setup(mesh, rigidity))->averaged_edges() == 0);
}

TEST_CASE(
    "invalid input of bending is refused with the requirement, the given value and the remedy") {
  const BendingSetup good = flat_setup(grid_cells(1.0, 1.0, 2, 2), isotropic(1.0, 0.3));
  const auto refused = [&](auto&& spoil, const std::string& what) {
    BendingSetup setup = good;
    spoil(setup);
    for (const std::string element : {"hinge", "midedge"}) {
      CAPTURE(element, what);
      CHECK_THROWS_AS(make_bending(element, setup), InvalidInput);
      CHECK_THROWS_WITH(make_bending(element, setup), Catch::Contains(what));
    }
  };
  refused([](BendingSetup& s) { s.corners.pop_back(); },
          "corners must have one entry per triangle (8), got 7");
  refused([](BendingSetup& s) { s.rigidity.pop_back(); },
          "rigidity must have one entry per triangle (8), got 7");
  refused([](BendingSetup& s) { s.damping.pop_back(); },
          "damping must have one entry per triangle (8), got 7");
  refused([](BendingSetup& s) { s.prescribed.pop_back(); },
          "prescribed must have one entry per vertex (9), got 8");
  refused([](BendingSetup& s) { s.rest_angles = {0.1}; },
          "rest_angles must have one entry per hinge (8), got 1");
  refused([](BendingSetup& s) { s.rest_angles.assign(8, 0.0), s.rest_angles[2] = 4.0; },
          "rest_angles[2] must be in (-pi, pi) [rad], got 4");
  refused([](BendingSetup& s) { s.rigidity[3](0, 1) = 2.0; },
          "rigidity[3] must be finite and symmetric");
  refused([](BendingSetup& s) { s.rigidity[3](0, 1) = s.rigidity[3](1, 0) = 2.0; },
          "rigidity[3] must be positive semi-definite");
  refused([](BendingSetup& s) { s.damping[1] = -1.0; }, "damping[1] must be >= 0 [s], got -1");
  refused([](BendingSetup& s) { s.corners[5].row(2) = s.corners[5].row(1); },
          "corners[5] must be three points with a rest area");
}
