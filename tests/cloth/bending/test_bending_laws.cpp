// Tests of both bending elements: derivatives, symmetries, damping, rest shapes, eigenvalues, and
// subsets of triangles.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "core/cloth/bending/bending_subset.h"
#include "core/mesh/generators.h"
#include "tests/cloth/bending/bending_support.h"
#include "tests/support/decompositions.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

const Team team;

double points_dot(const Points& a, const Points& b) { return (a.array() * b.array()).sum(); }

Points forces(const Bending& bending, const Points& x, const Points& v) {
  Points f = Points::Zero(x.rows(), 3);
  bending.add_forces(team, x, v, 0, static_cast<Index>(x.rows()), f);
  return f;
}
Points forces(const Bending& bending, const Points& x) {
  return forces(bending, x, Points::Zero(x.rows(), 3));
}

Eigen::MatrixXd as_dense(const BlockMatrix& k) {
  const Index n = k.n_rows();
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (Index i = 0; i < n; ++i)
    for (Index p = k.row_start()[i]; p < k.row_start()[i + 1]; ++p)
      full.block<3, 3>(3 * i, 3 * k.columns()[p]) = k.block_map(p);
  return full;
}

Eigen::MatrixXd dense(const Bending& bending, const Points& x, double scale_k, double scale_d) {
  const Index n = static_cast<Index>(x.rows());
  BlockMatrix k(n, bending.couplings());
  bending.add_stiffness(team, x, {scale_k, scale_d}, 0, n, k);
  return as_dense(k);
}

Vector flat(const Points& p) { return Eigen::Map<const Vector>(p.data(), p.size()); }

// A damped jittered sheet of 1 m x 0.8 m with a full rigidity matrix and random rest angles.
BendingSetup general_setup() {
  BendingSetup setup = flat_setup(jittered_grid(1.0, 0.8, 5, 4, 0.2), some_rigidity(), 0.4);
  setup.damping.assign(setup.triangles.rows(), 0.01);
  setup.damping[3] = 0.02;
  const auto n_hinges = make_hinge_bending(setup)->hinges().size();
  const Points angles = noise(static_cast<Index>(n_hinges), 0.5, 11);
  for (std::size_t e = 0; e < n_hinges; ++e) setup.rest_angles.push_back(angles(e, 0));
  return setup;
}

}  // namespace

TEST_CASE("the bending force is minus the gradient of the energy, to second order in the step") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const BendingSetup setup = general_setup();
  const auto bending = make_bending(element, setup);
  const Index n = static_cast<Index>(setup.rest_positions.rows());
  const Points x = setup.rest_positions + noise(n, 0.05, 1), direction = noise(n, 1.0, 2);
  const double exact = -points_dot(forces(*bending, x), direction);
  std::vector<double> errors;
  for (const double h : {4e-3, 2e-3, 1e-3, 5e-4}) {
    const double slope =
        (bending->energy(team, x + h * direction) - bending->energy(team, x - h * direction)) /
        (2.0 * h);
    errors.push_back(std::abs(slope - exact) / std::abs(exact));
  }
  for (std::size_t k = 0; k + 1 < errors.size(); ++k) {
    CAPTURE(errors[k], errors[k + 1]);
    CHECK(std::log2(errors[k] / errors[k + 1]) == Approx(2.0).margin(0.2));
  }
  CHECK(errors.back() < 1e-3);
}

TEST_CASE("at rest the Gauss-Newton stiffness is the exact Hessian") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const BendingSetup setup = flat_setup(jittered_grid(1.0, 0.8, 5, 4, 0.2), some_rigidity(), 0.4);
  const auto bending = make_bending(element, setup);
  const Points& x = setup.rest_positions;
  const Points direction = noise(static_cast<Index>(x.rows()), 1.0, 3);
  const Vector exact = dense(*bending, x, 1.0, 0.0) * flat(direction);
  std::vector<double> errors;
  for (const double h : {2e-3, 1e-3, 5e-4}) {
    const Points difference =
        (forces(*bending, x - h * direction) - forces(*bending, x + h * direction)) / (2.0 * h);
    errors.push_back((flat(difference) - exact).norm() / exact.norm());
  }
  CAPTURE(errors);
  for (std::size_t k = 0; k + 1 < errors.size(); ++k)
    CHECK(std::log2(errors[k] / errors[k + 1]) == Approx(2.0).margin(0.2));
  CHECK(errors.back() < 1e-3);
}

TEST_CASE("with its geometric part the bending stiffness is the exact Hessian in any shape") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const BendingSetup setup = general_setup();
  const auto bending = make_bending(element, setup);
  const Index n = static_cast<Index>(setup.rest_positions.rows());
  const Points x = setup.rest_positions + noise(n, 0.05, 14), direction = noise(n, 1.0, 15);
  BlockMatrix k(n, bending->couplings());
  bending->add_stiffness(team, x, {2.0, 0.0}, 0, n, k);
  bending->add_geometric_stiffness(team, x, 2.0, 0, n, k);
  const Eigen::MatrixXd full = as_dense(k);
  CHECK((full - full.transpose()).cwiseAbs().maxCoeff() <= 1e-13 * full.cwiseAbs().maxCoeff());
  const Vector exact = full * flat(direction);
  std::vector<double> errors;
  for (const double h : {8e-4, 4e-4, 2e-4, 1e-4}) {
    const Points difference =
        (forces(*bending, x - h * direction) - forces(*bending, x + h * direction)) / h;
    errors.push_back((flat(difference) - exact).norm() / exact.norm());
  }
  CAPTURE(errors);
  for (std::size_t i = 0; i + 1 < errors.size(); ++i)
    CHECK(std::log2(errors[i] / errors[i + 1]) == Approx(2.0).margin(0.2));
  CHECK(errors.back() < 1e-3);
  // Assembly in two ranges of rows on three threads gives the same bits as assembly of all rows on
  // one thread.
  BlockMatrix parts(n, bending->couplings());
  for (const auto& [begin, end] :
       {std::pair<Index, Index>(0, 11), std::pair<Index, Index>(11, n)}) {
    bending->add_stiffness(Team{3}, x, {2.0, 0.0}, begin, end, parts);
    bending->add_geometric_stiffness(Team{3}, x, 2.0, begin, end, parts);
  }
  CHECK(as_dense(parts) == full);
}

TEST_CASE(
    "the bending stiffness and damping matrices are symmetric and positive semi-definite in any "
    "shape") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const BendingSetup setup = general_setup();
  const auto bending = make_bending(element, setup);
  const Points x =
      setup.rest_positions + noise(static_cast<Index>(setup.rest_positions.rows()), 0.15, 4);
  for (const Eigen::MatrixXd& k : {dense(*bending, x, 1.0, 0.0), dense(*bending, x, 0.0, 1.0)}) {
    const double size = k.cwiseAbs().maxCoeff();
    // The tolerance covers rounding of sums of a few dozen terms.
    CHECK((k - k.transpose()).cwiseAbs().maxCoeff() <= 1e-14 * size);
    const Vector eigenvalues = test::eigenvalues(0.5 * (k + k.transpose()));
    CHECK(eigenvalues(0) >= -1e-13 * eigenvalues(eigenvalues.size() - 1));
  }
  // add_stiffness() multiplies stiffness and damping by their scales and adds both to the matrix.
  const Eigen::MatrixXd both = dense(*bending, x, 2.0, 3.0);
  const Eigen::MatrixXd apart =
      2.0 * dense(*bending, x, 1.0, 0.0) + 3.0 * dense(*bending, x, 0.0, 1.0);
  CHECK((both - apart).cwiseAbs().maxCoeff() <= 1e-14 * both.cwiseAbs().maxCoeff());
}

TEST_CASE(
    "bending damping dissipates energy, is the damping matrix times velocity, and does not act on "
    "rigid motion") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const BendingSetup setup = general_setup();
  const auto bending = make_bending(element, setup);
  const Index n = static_cast<Index>(setup.rest_positions.rows());
  const Points x = setup.rest_positions + noise(n, 0.05, 5);
  const Points elastic = forces(*bending, x);
  const Eigen::MatrixXd d = dense(*bending, x, 0.0, 1.0);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Points v = noise(n, 1.0, 100 + seed), damping = forces(*bending, x, v) - elastic;
    CHECK(points_dot(damping, v) < 0.0);
    // The tolerance covers the rounding error of the difference of two forces.
    CHECK((flat(damping) + d * flat(v)).norm() <= 1e-11 * flat(damping).norm());
  }
  Points rigid(n, 3);
  const Vec3 omega(0.3, -1.0, 0.7), shift(1.0, 2.0, -3.0);
  for (Index i = 0; i < n; ++i) rigid.row(i) = (shift + omega.cross(Vec3(x.row(i)))).transpose();
  // The scale is the damping force for random velocities that are about as large as those of the
  // rigid motion.
  const double scale = (d * flat(noise(n, 3.0, 6))).norm();
  CHECK((forces(*bending, x, rigid) - elastic).norm() <= 1e-12 * scale);
}

TEST_CASE("bending forces have neither sum nor torque, and rigid motion changes no energy") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const BendingSetup setup = general_setup();
  const auto bending = make_bending(element, setup);
  const Index n = static_cast<Index>(setup.rest_positions.rows());
  const Points x = setup.rest_positions + noise(n, 0.1, 7), f = forces(*bending, x);
  Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0.0;
  for (Index i = 0; i < n; ++i) {
    sum += f.row(i).transpose();
    torque += Vec3(x.row(i)).cross(Vec3(f.row(i)));
    size += f.row(i).norm();
  }
  CHECK(sum.norm() <= 1e-14 * size);
  CHECK(torque.norm() <= 1e-14 * size);
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  const Points moved = (x * turn.transpose()).rowwise() + Eigen::RowVector3d(0.3, 0.1, -0.2);
  CHECK(bending->energy(team, moved) == Approx(bending->energy(team, x)).epsilon(1e-12));
  CHECK((forces(*bending, moved) - f * turn.transpose()).norm() <= 1e-11 * f.norm());
}

TEST_CASE(
    "a curved rest shape has neither energy nor force at rest, and flattening it costs what "
    "bending it did") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  const TriangleMesh mesh = grid_cells(1.0, 0.5, 20, 10);
  BendingSetup setup = flat_setup(mesh, isotropic(1.0, 0.0));
  const auto flat_bending = make_bending(element, setup);
  Points rolled = mesh.vertices();
  const double radius = 0.4;
  for (Index i = 0; i < rolled.rows(); ++i) {
    const double angle = mesh.vertices()(i, 0) / radius;
    rolled.row(i) << radius * std::sin(angle), mesh.vertices()(i, 1),
        radius * (1.0 - std::cos(angle));
  }
  setup.rest_positions = rolled;
  setup.flat_rest = false;
  const auto curved = make_bending(element, setup);
  CHECK(curved->energy(team, rolled) == 0.0);
  const double scale = forces(*curved, mesh.vertices()).cwiseAbs().maxCoeff();
  // The tolerance covers rounding: the hinge element subtracts two values of sin(rest / 2), one
  // computed from the rest angle and one from the positions.
  CHECK(forces(*curved, rolled).cwiseAbs().maxCoeff() <= 1e-14 * scale);
  // With the mid-edge element, flattening the curved mesh costs as much energy as rolling the flat
  // one. With the hinge element, the two energies differ by the fraction r^2 / 24, where r = 0.125
  // rad is the hinge angle.
  CHECK(curved->energy(team, mesh.vertices()) ==
        Approx(flat_bending->energy(team, rolled)).epsilon(0.01));
}

TEST_CASE("a crease rests at its given rest angles") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  Points x(4, 3);
  x << 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, -0.5, 0.0, 0.0, 0.5, 0.0, 0.0;
  Triangles triangles(2, 3);
  triangles << 0, 2, 3, 1, 3, 2;
  BendingSetup setup = flat_setup(x, triangles, isotropic(1.0, 0.0));
  const double fold = 2.0;  // more than a right angle
  setup.rest_angles = {fold};
  const auto bending = make_bending(element, setup);
  double least = 1e300;
  for (const double sign : {1.0, -1.0}) {
    Points folded = x;
    folded.row(0) << 0.0, std::cos(fold), -sign * std::sin(fold);
    least = std::min(least, bending->energy(team, folded));
  }
  CHECK(least <= 1e-25);  // the fold with the sign of the rest angle stores no energy
  CHECK(bending->energy(team, x) > 0.1);
}

TEST_CASE(
    "the angle of a hinge is that of the standard library, to a few units in the last place") {
  Points x(4, 3);
  Triangles triangles(2, 3);
  triangles << 0, 2, 3, 1, 3, 2;
  double worst = 0.0;
  for (int k = -3141; k <= 3141; ++k) {
    const double angle = 1e-3 * k;
    x << 0.0, std::cos(angle), std::sin(angle), 0.0, -1.0, 0.0, -0.5, 0.0, 0.0, 0.5, 0.0, 0.0;
    BendingSetup setup = flat_setup(x, triangles, isotropic(1.0, 0.0));
    setup.corners[0] << 0.0, 1.0, -0.5, 0.0, 0.5, 0.0;
    setup.flat_rest = false;
    const double measured = std::abs(make_hinge_bending(setup)->rest_angles()[0]);
    worst = std::max(worst, std::abs(measured - std::abs(angle)) / std::max(1e-3, std::abs(angle)));
  }
  CHECK(worst < 1e-14);  // rounding errors of the normals
}

TEST_CASE(
    "rotating material axes and rigidity together in each triangle does not change the energy") {
  const TriangleMesh mesh = jittered_grid(1.0, 0.8, 6, 5, 0.2);
  const Points x = mesh.vertices() + noise(mesh.n_vertices(), 0.05, 8),
               turns = noise(mesh.n_triangles(), 3.0, 9);
  BendingSetup setup = flat_setup(mesh, some_rigidity());
  setup.prescribed[0] = setup.prescribed[1] = setup.prescribed[7] = setup.prescribed[8] = 1;
  for (const std::string element : {"hinge", "midedge"}) {
    CAPTURE(element);
    const double energy = make_bending(element, setup)->energy(team, x);
    BendingSetup turned = setup;
    for (Index t = 0; t < mesh.n_triangles(); ++t) {
      const double c = std::cos(turns(t, 0)), s = std::sin(turns(t, 0));
      Mat2 rotation;  // from the old axes to the new ones
      rotation << c, s, -s, c;
      turned.corners[t] = setup.corners[t] * rotation.transpose();
      Mat3 back;  // maps curvatures (kxx, kyy, 2 kxy) in the new axes to those in the old axes
      back << c * c, s * s, -c * s, s * s, c * c, c * s, 2.0 * c * s, -2.0 * c * s, c * c - s * s;
      const Mat3 d = back.transpose() * setup.rigidity[t] * back;
      turned.rigidity[t] = 0.5 * (d + d.transpose());
    }
    CHECK(make_bending(element, turned)->energy(team, x) == Approx(energy).epsilon(1e-12));
  }
}

TEST_CASE("the largest eigenvalue approximates that of the dense problem on free rows from below") {
  const std::string element = GENERATE("hinge", "midedge");
  CAPTURE(element);
  BendingSetup setup = flat_setup(grid_cells(1.0, 0.6, 10, 6), isotropic(1.0, 0.3));
  const auto free = make_bending(element, setup);
  for (Index i = 0; i < 22; ++i) setup.prescribed[i] = 1;
  const auto bending = make_bending(element, setup);
  const Vector mass = lumped_areas(setup.rest_positions, setup.triangles);
  Eigen::MatrixXd k = dense(*bending, setup.rest_positions, 1.0, 0.0);
  for (Index i = 0; i < k.rows(); ++i)
    for (Index j = 0; j < k.cols(); ++j)
      k(i, j) *= setup.prescribed[i / 3] || setup.prescribed[j / 3]
                     ? 0.0
                     : 1.0 / std::sqrt(mass[i / 3] * mass[j / 3]);
  const double exact = test::eigenvalues(k).maxCoeff();
  const double found = bending->largest_eigenvalue(mass);
  CHECK(found <= exact * (1.0 + 1e-12));
  // An error of 3 % is harmless: with the Euler schemes, the longest step with explicit bending has
  // a margin of 20 % (bending_is_implicit() in core/integration/integrator.cpp).
  CHECK(found >= 0.97 * exact);
  CHECK(free->largest_eigenvalue(mass) > 0.0);
}

TEST_CASE("the forces of subsets of triangles add up to those of all, with both elements") {
  const BendingSetup setup = general_setup();
  const Index n = static_cast<Index>(setup.rest_positions.rows());
  const EdgeTable edges = edge_table(n, setup.triangles);
  const Points x = setup.rest_positions + noise(n, 0.05, 3), v = noise(n, 1.0, 4);
  for (const char* const element : {"hinge", "midedge"}) {
    const Points whole = forces(*make_bending(element, setup), x, v);
    Points sum = Points::Zero(n, 3);
    for (Index part = 0; part < 3; ++part) {
      std::vector<Index> acting;
      for (Index t = part; t < setup.triangles.rows(); t += 3) acting.push_back(t);
      const BendingSubset subset = bending_subset(setup, edges, acting);
      const Points own = forces(*make_bending(element, subset.setup),
                                x(subset.vertices, Eigen::all), v(subset.vertices, Eigen::all));
      for (std::size_t i = 0; i < subset.vertices.size(); ++i)
        sum.row(subset.vertices[i]) += own.row(static_cast<Index>(i));
    }
    INFO(element);
    CHECK((sum - whole).norm() < 1e-13 * whole.norm());  // up to rounding
  }
}

TEST_CASE("a subset of triangles takes only the vertices of its neighbourhood") {
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 20, 20);
  const BendingSetup setup = flat_setup(mesh, some_rigidity());
  const BendingSubset subset =
      bending_subset(setup, edge_table(mesh.n_vertices(), setup.triangles), {400});
  // A triangle and two rings of its neighbours have at most 12 vertices.
  CHECK(subset.vertices.size() < 15);
  CHECK(std::is_sorted(subset.vertices.begin(), subset.vertices.end()));
}
