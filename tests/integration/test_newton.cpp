// Tests of the Newton loops of backward Euler and of the nonlinear midpoint rule.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "tests/support/cloth_fixture.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

ClothMaterial newton_material() {
  ClothMaterial m;
  m.weft_stiffness = 300, m.warp_stiffness = 200, m.shear_stiffness = 100;
  return m;
}

}  // namespace

TEST_CASE("with the exact Jacobian Newton's residual is squared from one iteration to the next") {
  const std::string method = GENERATE("backward-euler", "nonlinear-midpoint");
  const std::string element = GENERATE("mid-edge", "hinge");
  CAPTURE(method, element);
  // A spinning sheet under tension, rolled to hinge angles of about 0.5 rad, at which the geometric
  // stiffness of bending matters.
  const TriangleMesh mesh = jittered_grid(0.2, 0.2, 5, 5, 0.2, 3);
  IntegratorOptions o = exact_options(method.c_str(), 5e-3);
  o.implicit()->bending = BendingInStep::Implicit, o.newton()->newton_tolerance = 1e-13;
  ClothRun run = make_run(mesh, newton_material(), o, {1e-3, {}, Vec3(0, 0, -9.81), element});
  start(run, o);
  const double radius = 0.08;
  for (Index i = 0; i < mesh.n_vertices(); ++i) {
    const double a = mesh.vertices()(i, 0) / radius;
    run.state.x.row(i) << 1.05 * radius * std::sin(a), 1.1 * mesh.vertices()(i, 1),
        1.05 * radius * std::cos(a);
    run.state.v.row(i) = Vec3(1, 2, 6).cross(run.state.x.row(i).transpose()).transpose();
  }
  const IntegrationReport report = run.advance();
  const std::vector<double>& r = report.newton_residuals;
  CAPTURE(r);
  REQUIRE(r.size() >= 4);
  CHECK(r.size() == static_cast<std::size_t>(report.newton_iterations) + 1);
  int n_squared = 0;
  for (std::size_t k = 0; k + 1 < r.size(); ++k) {
    if (r[k] > 1e-2 || r[k + 1] < 1e-13) continue;  // too far from the solution, or below rounding
    // Quadratic convergence means r_{k+1} <= C r_k^2 with one constant C. Linear convergence would
    // violate this bound after some iterations.
    CHECK(r[k + 1] <= 30.0 * r[k] * r[k]);
    ++n_squared;
  }
  CHECK(n_squared >= 1);
  CHECK(report.newton_iterations <= 8);
}

TEST_CASE(
    "the Newton loop follows a sheet compressed far beyond buckling in a few steps, with either "
    "bending element") {
  const std::string element = GENERATE("mid-edge", "hinge");
  const std::string method = GENERATE("backward-euler", "nonlinear-midpoint");
  CAPTURE(element, method);
  const TriangleMesh mesh = grid_cells(0.2, 0.1, 20, 10);
  IntegratorOptions o = integrator_named(method);
  o.set_step(4e-3);
  o.implicit()->bending = BendingInStep::Implicit,
  o.implicit()->linear_solver = LinearMethod::Direct;
  std::vector<Index> pins;
  for (Index i = 0; i < mesh.n_vertices(); ++i)
    if (std::abs(mesh.vertices()(i, 0)) > 0.1 - 1e-9) pins.push_back(i);
  ClothRun run = make_run(mesh, newton_material(), o, {1e-5, pins, Vec3(0, 0, -9.81), element});
  start(run, o);
  int most = 0;
  for (int k = 0; k < 40; ++k) {
    // The compression grows to 10 % within 80 ms. From the first step on, the flat sheet is near a
    // saddle point of the potential.
    const double pressed = 1.0 - 0.1 * std::min(1.0, (k + 1) / 20.0);
    for (const Index pin : pins) run.target(pin, 0) = pressed * mesh.vertices()(pin, 0);
    const IntegrationReport report = run.advance();
    most = std::max(most, report.newton_iterations);
    CHECK(report.residual <= o.newton()->newton_tolerance);
  }
  CHECK(most <= 30);
  // The sheet has buckled. At 10 % compression, a single half-wave is about 4 cm high. The bound of
  // 1 cm also admits several half-waves, which are lower.
  CHECK(run.state.x.col(2).maxCoeff() - run.state.x.col(2).minCoeff() > 0.01);
}

TEST_CASE(
    "a Newton loop that cannot converge reports this, the remedy, and where the residual is "
    "largest") {
  const TriangleMesh mesh = grid_cells(0.2, 0.2, 4, 4);
  IntegratorOptions o = exact_options("backward-euler", 1e-3);
  o.newton()->newton_tolerance = 1e-30, o.newton()->max_newton_iterations = 3;
  ClothRun run = make_run(mesh, newton_material(), o, {0.0, {0}, Vec3(0, 0, -9.81)});
  start(run, o);
  CHECK_THROWS_WITH(run.advance(),
                    Catch::Contains("backward-euler") && Catch::Contains("integrator.step"));
  run = make_run(mesh, newton_material(), o, {0.0, {0}, Vec3(0, 0, -9.81)});
  run.force(7, 0) = 100.0;  // [N], pulls one vertex away
  o.newton()->max_newton_iterations = 1;
  start(run, o);
  try {
    run.advance();
    FAIL("one iteration does not solve this");
  } catch (const NewtonFailure& failure) {
    CHECK(failure.row == 7);
  }
}

TEST_CASE("Newton loops move cloth without loads at constant velocity") {
  const std::string method = GENERATE("backward-euler", "nonlinear-midpoint");
  const double speed = GENERATE(0.0, 3.0);
  CAPTURE(method, speed);
  const TriangleMesh mesh = grid_cells(0.2, 0.2, 12, 12);
  const IntegratorOptions o = exact_options(method.c_str(), 4e-3);
  ClothRun run = make_run(mesh, newton_material(), o, {1e-5, {}, Vec3::Zero()});
  const Vec3 velocity = speed * Vec3(0.6, 0.0, 0.8);
  // The sheet is turned, so that its strains are rounding errors instead of zero.
  const Eigen::AngleAxisd turn(0.4, Vec3(1, 0.3, 0).normalized());
  for (Index i = 0; i < mesh.n_vertices(); ++i) {
    run.state.x.row(i) = (turn * Vec3(mesh.vertices().row(i))).transpose();
    run.state.v.row(i) = velocity.transpose();
  }
  start(run, o);
  for (int k = 0; k < 20; ++k) CHECK(run.advance().newton_iterations <= 30);
  for (Index i = 0; i < mesh.n_vertices(); ++i)
    // In 80 ms, rounding errors of about 1e-13 N in the elastic forces accelerate vertices of
    // 1e-4 kg to about 1e-10 m/s.
    CHECK((run.state.v.row(i).transpose() - velocity).norm() < 1e-9);
}
