// Tests of large deflections of the mid-edge element, compared with the elastica.
#include <catch2/catch.hpp>

#include <cmath>

#include <Eigen/SparseCholesky>

#include "core/cloth/membrane/membrane.h"
#include "tests/cloth/bending/bending_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// Returns the tip height of an inextensible cantilever under a dead load w per unit length. Writes
// the tip's x to tip_x. Solves B theta'' = -w (L - s) cos(theta) by shooting, with B = L = 1. Here
// theta is the downward slope angle at the arc length s from the clamp.
double elastica_tip(double w, double& tip_x) {
  double low = 0.0, high = 20.0;
  double x = 0.0, z = 0.0;
  for (int k = 0; k < 60; ++k) {
    const double start = 0.5 * (low + high);  // downward curvature at the clamp
    const int n = 2000;
    const double h = 1.0 / n;
    double theta = 0.0, kappa = start;
    x = z = 0.0;
    for (int i = 0; i < n; ++i) {
      const double s = i * h;
      const auto slope = [&](double at, double t) { return -w * (1.0 - at) * std::cos(t); };
      const double k1 = slope(s, theta), t2 = theta + 0.5 * h * kappa, k2 = slope(s + 0.5 * h, t2);
      const double t3 = theta + 0.5 * h * (kappa + 0.5 * h * k1), k3 = slope(s + 0.5 * h, t3);
      const double t4 = theta + h * (kappa + 0.5 * h * k2), k4 = slope(s + h, t4);
      const double middle = theta + 0.5 * h * (kappa + 0.25 * h * k1);
      const double next = theta + h * (kappa + h * (k1 + k2 + k3) / 6.0);
      x += h * (std::cos(theta) + 4.0 * std::cos(middle) + std::cos(next)) / 6.0;
      z -= h * (std::sin(theta) + 4.0 * std::sin(middle) + std::sin(next)) / 6.0;
      theta = next;
      kappa += h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
    }
    (kappa > 0.0 ? high : low) = start;  // the moment at the free end must vanish
  }
  tip_x = x;
  return z;
}

// Minimises the energy of membrane, bending and load by Newton's method with a line search. Uses
// the positive semi-definite Jacobian if the exact one is not positive definite.
class StaticSolve {
 public:
  StaticSolve(const Strip& strip, const Bending& bending, Membrane& membrane)
      : strip_(strip),
        bending_(bending),
        membrane_(membrane),
        area_(lumped_areas(strip.vertices, strip.triangles)) {
    auto couplings = bending.couplings();
    n_ = static_cast<Index>(strip.vertices.rows());
    for (Index t = 0; t < strip.triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k)
        couplings.emplace_back(strip.triangles(t, k), strip.triangles(t, (k + 1) % 3));
    matrix_ = BlockMatrix(n_, couplings);
  }

  double potential(const Points& x, double load) {
    return membrane_.energy(team_, x) + bending_.energy(team_, x) + load * area_.dot(x.col(2));
  }

  // Takes one Newton step. Returns the norm of the residual before it, relative to the norm of the
  // load.
  double iterate(Points& x, double load) {
    Points g = Points::Zero(n_, 3);
    membrane_.add_forces(team_, x, nullptr, 0, n_, g);
    bending_.add_forces(team_, x, Points::Zero(n_, 3), 0, n_, g);
    g.col(2) -= load * area_;
    Vector b(3 * n_);
    for (Index i = 0; i < n_; ++i) {
      if (strip_.prescribed[i]) g.row(i).setZero();
      b.segment<3>(3 * i) = g.row(i).transpose();
    }
    if (!factorise(x, JacobianKind::Exact)) factorise(x, JacobianKind::Positive);
    const Vector step = solver_.solve(b);
    const Eigen::Map<const Points> dx(step.data(), n_, 3);
    const double before = potential(x, load), slope = -(g.array() * dx.array()).sum();
    double length = 1.0;
    while (length > 1e-6 && !(potential(x + length * dx, load) <= before + 1e-4 * length * slope))
      length *= 0.5;
    x += length * dx;
    return g.norm() / (load * area_).norm();
  }

 private:
  bool factorise(const Points& x, JacobianKind kind) {
    matrix_.set_zero();
    membrane_.set_jacobian(team_, x, {kind, {1.0, 0.0}}, 0, n_, matrix_);
    bending_.add_stiffness(team_, x, {1.0, 0.0}, 0, n_, matrix_);
    if (kind == JacobianKind::Exact)
      bending_.add_geometric_stiffness(team_, x, 1.0, 0, n_, matrix_);
    std::vector<Eigen::Triplet<double>> entries;
    for (Index i = 0; i < n_; ++i)
      for (Index p = matrix_.row_start()[i]; p < matrix_.row_start()[i + 1]; ++p) {
        const Index j = matrix_.columns()[p];
        const bool prescribed = strip_.prescribed[i] || strip_.prescribed[j];
        if (prescribed && i != j) continue;
        const Mat3 block = prescribed ? Mat3(Mat3::Identity()) : Mat3(matrix_.block_map(p));
        for (int k = 0; k < 9; ++k)
          entries.emplace_back(3 * i + k / 3, 3 * j + k % 3, block(k / 3, k % 3));
      }
    Eigen::SparseMatrix<double> k(3 * n_, 3 * n_);
    k.setFromTriplets(entries.begin(), entries.end());
    solver_.compute(k);
    return solver_.info() == Eigen::Success && solver_.vectorD().minCoeff() > 0.0;
  }

  const Strip& strip_;
  const Bending& bending_;
  Membrane& membrane_;
  Vector area_;
  Index n_;
  BlockMatrix matrix_;
  Team team_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
};

}  // namespace

TEST_CASE(
    "a heavy mid-edge cantilever hangs as the elastica does, up to a load that turns it nearly "
    "straight down") {
  // Compares elastica_tip() with the tip heights for w L^3 / B = 5 and 40, known to four digits.
  double x5 = 0.0, x40 = 0.0;
  const double z5 = elastica_tip(5.0, x5), z40 = elastica_tip(40.0, x40);
  CHECK(z5 == Approx(-0.4959).epsilon(2e-4));
  CHECK(z40 == Approx(-0.8946).epsilon(2e-4));

  const std::string pattern = GENERATE("alternating", "diagonal", "jittered", "along", "raw");
  CAPTURE(pattern);
  const Strip strip =
      pattern == "raw" ? random_strip(1.0, 0.2, 6, 4, 0) : make_strip(pattern, 1.0, 0.2, 6);
  BendingSetup setup = flat_setup(strip.vertices, strip.triangles, isotropic(1.0, 0.0));
  setup.prescribed = strip.prescribed;
  const auto bending = make_midedge_bending(setup);
  // The membrane is nearly inextensible. Its strain under the largest load is below 40 / 2e4 =
  // 0.2 %, and on average below half of that. Both are well below the tolerance of 1 %.
  const MembraneConstants constants{2e4, 2e4, 0.0, 1e4, 0.0, 0.0};
  Membrane membrane(static_cast<Index>(strip.vertices.rows()), strip.triangles, setup.corners,
                    std::vector<MembraneConstants>(strip.triangles.rows(), constants));
  StaticSolve solve(strip, *bending, membrane);
  Points x = strip.vertices;
  double residual = 1.0;
  for (const double load : {1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 18.0, 26.0, 40.0}) {
    const bool compared = load == 5.0 || load == 40.0;
    for (int k = 0; k < 100; ++k)
      if ((residual = solve.iterate(x, load)) < (compared ? 1e-6 : 1e-2)) break;
    if (!compared) continue;
    CAPTURE(load, residual);
    CHECK(residual < 1e-6);
    double z = 0.0, along = 0.0;
    for (const Index i : strip.tip)
      z += x(i, 2) / strip.tip.size(), along += x(i, 0) / strip.tip.size();
    CHECK(z == Approx(load == 5.0 ? z5 : z40).epsilon(0.01));
    CHECK(along == Approx(load == 5.0 ? x5 : x40).margin(0.01));
  }
}
