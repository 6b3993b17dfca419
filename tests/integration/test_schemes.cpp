// Tests of the integrators of docs/method.md, section "Integrators".
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>

#include "core/base/error.h"
#include "tests/support/cloth_fixture.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

const char* const all_methods[] = {"explicit-euler", "symplectic-euler",  "semi-implicit-euler",
                                   "backward-euler", "implicit-midpoint", "nonlinear-midpoint",
                                   "bdf2",           "asynchronous"};

bool is_explicit(const std::string& method) {
  return method == "explicit-euler" || method == "symplectic-euler" || method == "asynchronous";
}

IntegratorOptions options_for(const std::string& method, double step) {
  IntegratorOptions o = exact_options(method.c_str(), step);
  return o;
}

ClothMaterial soft() {
  ClothMaterial m;
  m.weft_stiffness = 30, m.warp_stiffness = 20, m.shear_stiffness = 10;
  return m;
}

// Velocities of a rigid rotation and translation [m/s].
Points spinning(const Points& x) {
  Points v(x.rows(), 3);
  const Vec3 omega(1, 2, 6);
  for (Index i = 0; i < x.rows(); ++i)
    v.row(i) = omega.cross(x.row(i).transpose()).transpose() + Eigen::RowVector3d(0.3, 0, 0.1);
  return v;
}

// Returns the positions of a spinning sheet after 0.05 s, computed with the given step. The sheet
// starts bent, and stretched in its plane, so it is under tension everywhere. If the steps are
// unequal, their lengths alternate between 1.4 and 0.6 times the given one.
Points end_of_motion(const std::string& method, double step, double bending,
                     const char* treatment = nullptr, bool unequal = false) {
  const TriangleMesh mesh = jittered_grid(0.2, 0.2, 4, 4, 0.2, 3);
  IntegratorOptions o = options_for(method, step);
  if (ImplicitOptions* const implicit = o.implicit()) {
    implicit->bending = o.newton() ? BendingInStep::Implicit : BendingInStep::Explicit;
    if (treatment) implicit->bending = choice_named<BendingInStep>(treatment, "bending");
  }
  ClothRun run = make_run(mesh, soft(), o, {bending});
  start(run, o);
  run.state.x *= 1.15;
  run.state.x.col(2) = 0.02 * (12.0 * run.state.x.col(0).array()).sin();
  run.state.v = spinning(run.state.x);
  const int n = static_cast<int>(std::lround(0.05 / step));
  for (int i = 0; i < n; ++i) {
    if (unequal) run.step = step * (i % 2 == 0 ? 1.4 : 0.6);
    run.advance();
    if (unequal) run.state.previous_step = run.step;
  }
  return run.state.x;
}

double momentum_error(const ClothRun& run, const Vec3& expected) {
  Vec3 p = Vec3::Zero();
  for (Index i = 0; i < run.model.n_vertices; ++i)
    p += run.model.mass[i] * run.state.v.row(i).transpose();
  return (p - expected).norm() / expected.norm();
}

Vec3 angular_momentum(const ClothRun& run) {
  Vec3 l = Vec3::Zero();
  for (Index i = 0; i < run.model.n_vertices; ++i)
    l += run.model.mass[i] * run.state.x.row(i).transpose().cross(run.state.v.row(i).transpose());
  return l;
}

double angular_drift(const std::string& method, double step) {
  const TriangleMesh mesh = jittered_grid(0.2, 0.2, 4, 4, 0.2, 3);
  IntegratorOptions o = options_for(method, step);
  if (o.implicit()) o.implicit()->bending = BendingInStep::Implicit;
  ClothRun run = make_run(mesh, soft(), o, {1e-5});
  start(run, o);
  run.state.x *= 1.15;
  run.state.v = spinning(run.state.x);
  const Vec3 before = angular_momentum(run);
  for (int i = 0; i < static_cast<int>(std::lround(0.05 / step)); ++i) run.advance();
  return (angular_momentum(run) - before).norm() / before.norm();
}

}  // namespace

TEST_CASE("free fall: velocity is g t for every integrator, position has the scheme's own term") {
  for (const std::string method : all_methods) {
    // Explicit schemes use a stable step, implicit schemes a much longer one.
    const double h = is_explicit(method) ? 1e-4 : 0.01, g = 9.81;
    const int n = 20;
    const double t = n * h;
    const std::map<std::string, double> expected = {{"explicit-euler", 0.5 * g * t * (t - h)},
                                                    {"symplectic-euler", 0.5 * g * t * (t + h)},
                                                    {"semi-implicit-euler", 0.5 * g * t * (t + h)},
                                                    {"backward-euler", 0.5 * g * t * (t + h)},
                                                    {"implicit-midpoint", 0.5 * g * t * t},
                                                    {"nonlinear-midpoint", 0.5 * g * t * t},
                                                    {"asynchronous", 0.5 * g * t * t}};
    const TriangleMesh mesh = jittered_grid(0.2, 0.3, 3, 4, 0.2, 3);
    const IntegratorOptions o = options_for(method, h);
    ClothRun run = make_run(mesh, ClothMaterial{}, o, {1e-6, {}, Vec3(0, 0, -g)});
    start(run, o);
    for (int i = 0; i < n; ++i) run.advance();
    for (Index i = 0; i < mesh.n_vertices(); ++i) {
      CHECK(run.state.v(i, 2) == Approx(-g * t).epsilon(1e-9));
      if (expected.count(method))
        CHECK(run.state.x(i, 2) == Approx(-expected.at(method)).epsilon(1e-9));
      // BDF-2, started by a midpoint step, is exact for constant acceleration.
      if (method == std::string("bdf2"))
        CHECK(run.state.x(i, 2) == Approx(-0.5 * g * t * t).epsilon(1e-9));
    }
  }
}

TEST_CASE("midpoint and BDF-2 are of order 2, the Euler schemes of order 1") {
  const std::map<std::string, double> order = {{"explicit-euler", 1},
                                               {"symplectic-euler", 1},
                                               {"semi-implicit-euler", 1},
                                               {"backward-euler", 1},
                                               {"implicit-midpoint", 2},
                                               {"nonlinear-midpoint", 2},
                                               {"bdf2", 2}};
  for (const auto& [method, expected] : order) {
    // The sheet has no bending stiffness. The exact result is unknown, but it cancels in the
    // differences between runs with steps h, h / 2 and h / 4.
    const double h = is_explicit(method) ? 6.25e-5
                     : method == "bdf2"  ? 5e-4
                     : expected == 2     ? 1e-3
                                         : 1.25e-4;
    const Points a = end_of_motion(method, h, 0.0), b = end_of_motion(method, h / 2, 0.0),
                 c = end_of_motion(method, h / 4, 0.0);
    const double measured = std::log2((a - b).norm() / (b - c).norm());
    INFO(method << " has order " << measured);
    CHECK(measured == Approx(expected).margin(0.2));
  }
}

TEST_CASE("explicit bending, extrapolated, keeps the midpoint rules and BDF-2 of order 2") {
  for (const char* method : {"implicit-midpoint", "nonlinear-midpoint", "bdf2"}) {
    const double h = 5e-4;
    const auto end = [&](double step) { return end_of_motion(method, step, 1e-5, "explicit"); };
    const Points a = end(h), b = end(h / 2), c = end(h / 4);
    const double measured = std::log2((a - b).norm() / (b - c).norm());
    INFO(method << " has order " << measured);
    CHECK(measured == Approx(2.0).margin(0.3));
  }
}

TEST_CASE("steps of unequal length keep midpoint and BDF-2 of order 2") {
  for (const char* method : {"implicit-midpoint", "bdf2"})
    for (const double bending : {0.0, 1e-5}) {
      const double h = 5e-4;
      const auto end = [&](double step) {
        return end_of_motion(method, step, bending, "explicit", true);
      };
      const Points a = end(h), b = end(h / 2), c = end(h / 4);
      const double measured = std::log2((a - b).norm() / (b - c).norm());
      INFO(method << " has order " << measured);
      CHECK(measured == Approx(2.0).margin(0.3));
    }
}

TEST_CASE("the stable step of stretched cloth follows from its stiffening") {
  const TriangleMesh mesh = jittered_grid(0.2, 0.2, 4, 4, 0.2, 3);
  for (const double poisson : {-0.5, 0.0, 0.3, 0.9})
    for (const Vec3& stretch :
         {Vec3(1.3, 1.0, 1.0), Vec3(3.0, 1.0, 1.0), Vec3(3.0, 0.6, 1.0), Vec3(3.0, 3.0, 1.0)}) {
      ClothMaterial material = soft();
      material.poisson = poisson;
      const ClothModel model =
          make_run(mesh, material, options_for("symplectic-euler", 1e-4), {1e-5}).model;
      const Points x = mesh.vertices() * stretch.asDiagonal();
      Elasticity elasticity(model, BendingTreatment::Explicit);
      const double stiffening = stiffening_of_rank(elasticity, {}, x);
      const double rest = stable_step_at(model, mesh.vertices()), now = stable_step_at(model, x);
      CAPTURE(poisson, stretch.transpose(), stiffening, rest, now);
      // Automatic steps are at least a tenth shorter than the stable step that `stiffening`
      // predicts. Because of modes that also shear, the true stable step `now` may be shorter than
      // the predicted one by up to half of this margin.
      CHECK(now > 0.95 * rest / std::sqrt(stiffening));
      CHECK(stiffening < 2.0 * (rest / now) * (rest / now));
    }
}

TEST_CASE("symplectic Euler is stable below the stable step, and unstable above it") {
  const TriangleMesh mesh = jittered_grid(0.2, 0.2, 4, 4, 0.2, 3);
  for (const double viscosity : {0.0, 1e-3}) {
    ClothMaterial material = soft();
    material.viscosity_dilation = material.viscosity_shear = viscosity;
    const double limit = stable_step_at(
        make_run(mesh, material, options_for("symplectic-euler", 1e-4), {1e-5}).model,
        mesh.vertices());
    const auto largest = [&](double h) {
      const IntegratorOptions o = options_for("symplectic-euler", h);
      ClothRun run = make_run(mesh, material, o, {1e-5});
      start(run, o);
      // The perturbation lies in the plane of the sheet, where the membrane resists deformation.
      for (Index i = 0; i < mesh.n_vertices(); ++i)
        run.state.x(i, 0) += 1e-6 * std::sin(7.0 * i),
            run.state.x(i, 1) += 1e-6 * std::cos(5.0 * i);
      const Points& rest = mesh.vertices();
      double most = 0.0;
      for (int i = 0; i < 2000 && most < 1e-3; ++i) {
        run.advance();
        most = std::max(most, (run.state.x - rest).cwiseAbs().maxCoeff());
      }
      return most;
    };
    CAPTURE(viscosity, limit);
    CHECK(largest(0.95 * limit) < 2e-5);
    CHECK(largest(1.1 * limit) > 1e-3);
  }
}

TEST_CASE("implicit bending with the exact Jacobian keeps midpoint and BDF-2 of order 2") {
  for (const char* method : {"implicit-midpoint", "nonlinear-midpoint", "bdf2"}) {
    const double h = 5e-4;
    const auto end = [&](double step) { return end_of_motion(method, step, 1e-3, "implicit"); };
    const Points a = end(h), b = end(h / 2), c = end(h / 4);
    const double measured = std::log2((a - b).norm() / (b - c).norm());
    INFO(method << " has order " << measured);
    CHECK(measured == Approx(2.0).margin(0.3));
  }
}

TEST_CASE("linear momentum is kept to rounding by every integrator with the direct solver") {
  for (const std::string method : all_methods) {
    const TriangleMesh mesh = jittered_grid(0.2, 0.2, 4, 4, 0.2, 3);
    const IntegratorOptions o = options_for(method, 2e-4);
    ClothRun run = make_run(mesh, soft(), o, {1e-5});
    start(run, o);
    run.state.x *= 1.15;
    run.state.v = spinning(run.state.x);
    Vec3 before = Vec3::Zero();
    for (Index i = 0; i < run.model.n_vertices; ++i)
      before += run.model.mass[i] * run.state.v.row(i).transpose();
    for (int i = 0; i < 200; ++i) run.advance();
    INFO(method);
    // The tolerance covers rounding in 200 steps. The rounding errors are those of large internal
    // forces, which cancel in the total momentum.
    CHECK(momentum_error(run, before) < 1e-11);
  }
}

TEST_CASE(
    "angular momentum is conserved to rounding by symplectic Euler, asynchronous steps and "
    "nonlinear midpoint, to order 3 by BDF-2, and to their order by the others") {
  CHECK(angular_drift("symplectic-euler", 2e-4) < 1e-12);
  CHECK(angular_drift("asynchronous", 2e-3) < 1e-12);
  CHECK(angular_drift("nonlinear-midpoint", 1e-3) < 1e-11);  // Newton stops at a residual of 1e-12
  // BDF-2 has order 3 here: its h^2 error only shifts the phase, and its loss of angular momentum
  // per unit of time is of order h^3.
  const std::map<std::string, std::pair<double, double>> step_and_order = {
      {"explicit-euler", {5e-5, 1}},
      {"semi-implicit-euler", {2.5e-4, 1}},
      {"backward-euler", {2.5e-4, 1}},
      {"implicit-midpoint", {5e-4, 2}},
      {"bdf2", {5e-4, 3}}};
  for (const auto& [method, expected] : step_and_order) {
    const auto [h, order] = expected;
    const double measured = std::log2(angular_drift(method, h) / angular_drift(method, h / 2));
    INFO(method << " has order " << measured);
    CHECK(measured == Approx(order).margin(0.25));
  }
}

TEST_CASE("pinned vertices do not move by one bit, scripted ones end exactly at their target") {
  for (const std::string method : all_methods) {
    const TriangleMesh mesh = grid_cells(0.3, 0.3, 6, 6);
    IntegratorOptions o = options_for(method, 2e-4);
    if (ImplicitOptions* const implicit = o.implicit())
      implicit->linear_solver = LinearMethod::Pcg, implicit->jacobian = JacobianKind::Positive;
    if (NewtonOptions* const newton = o.newton()) newton->newton_tolerance = 1e-6;
    ClothRun run = make_run(mesh, ClothMaterial{}, o, {1e-6, {0, 6}, Vec3(0, 0, -9.81)});
    start(run, o);
    for (int i = 0; i < 50; ++i) {
      run.target(6, 0) = mesh.vertices()(6, 0) + 1e-4 * i;
      run.advance();
    }
    INFO(method);
    CHECK(run.state.x.row(0) == mesh.vertices().row(0));
    CHECK(run.state.x.row(6) == run.target.row(6));
    CHECK(run.state.x(40, 2) < -1e-6);
  }
}

// Length [m] of a strip that hangs under its own weight with uniaxial stress. At a point with the
// rest length s below it, the stretch lambda satisfies E lambda (lambda^2 - 1) / 2 = rho g s. The
// hanging length is the integral of lambda. weight: rho g [N/m^2], modulus: E [N/m].
double hung_length(double length, double weight, double modulus) {
  const int parts = 2000;
  double hang = 0.0;
  for (int i = 0; i < parts; ++i) {
    const double load = weight * length * (i + 0.5) / parts;
    double lambda = 1.0;
    for (int k = 0; k < 30; ++k)
      lambda -= (0.5 * modulus * lambda * (lambda * lambda - 1) - load) /
                (0.5 * modulus * (3 * lambda * lambda - 1));
    hang += lambda * length / parts;
  }
  return hang;
}

TEST_CASE("a hanging strip stretches as the analytic solution, along weft and along warp") {
  // With nu = 0, a strip under its own weight deforms only along its length.
  ClothMaterial m;
  m.weft_stiffness = 60, m.warp_stiffness = 25, m.shear_stiffness = 10, m.density = 0.8;
  const double g = 9.81, length = 1.0;
  for (const bool weft : {true, false}) {
    const double hang =
        hung_length(length, m.density * g, weft ? m.weft_stiffness : m.warp_stiffness);
    const Index across = 2, along = 24;
    const TriangleMesh mesh =
        weft ? grid_cells(length, 0.1, along, across) : grid_cells(0.1, length, across, along);
    std::vector<Index> pins;
    Vec3 gravity = Vec3::Zero();
    for (Index i = 0; i < mesh.n_vertices(); ++i)
      if (mesh.uv()(i, weft ? 0 : 1) > length / 2 - 1e-9) pins.push_back(i);
    gravity[weft ? 0 : 1] = -g;
    IntegratorOptions o = exact_options("backward-euler", 0.1);
    o.newton()->newton_tolerance = 1e-9;
    ClothRun run = make_run(mesh, m, o, {0.0, pins, gravity});
    start(run, o);
    for (int i = 0; i < 60; ++i) run.advance();
    const double bottom = run.state.x.col(weft ? 0 : 1).minCoeff();
    // The tolerance covers the second-order error of linear triangles (24 cells lengthwise).
    CHECK(length / 2 - bottom == Approx(hang).epsilon(1e-3));
  }
}

TEST_CASE(
    "a hanging strip with a Poisson ratio stretches by its compliance along weft, warp and bias") {
  // The strip is narrow with free sides, so its stress is uniaxial, and its elastic modulus is the
  // reciprocal of the off-axis compliance. The clamp prevents lateral contraction, and coupling to
  // shear bends the strip in its plane. The errors from both effects are smaller for a narrower
  // strip.
  ClothMaterial m;
  m.weft_stiffness = 60, m.warp_stiffness = 25, m.shear_stiffness = 10, m.poisson = 0.3,
  m.density = 0.8;
  const double g = 9.81, length = 1.0, width = 0.04;
  for (const double degrees : {0.0, 45.0, 90.0}) {
    const double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
    const double compliance =
        std::pow(c, 4) / m.weft_stiffness + std::pow(s, 4) / m.warp_stiffness +
        c * c * s * s * (1 / m.shear_stiffness - 2 * m.poisson / m.weft_stiffness);
    const double hang = hung_length(length, m.density * g, 1 / compliance);
    const TriangleMesh base = grid_cells(length, width, 50, 2);
    Mat2 turn;
    turn << c, -s, s, c;
    const TriangleMesh mesh(base.vertices(), base.triangles(), base.uv() * turn.transpose());
    std::vector<Index> pins;
    for (Index i = 0; i < mesh.n_vertices(); ++i)
      if (base.uv()(i, 0) > length / 2 - 1e-9) pins.push_back(i);
    IntegratorOptions o = exact_options("backward-euler", 0.1);
    o.newton()->newton_tolerance = 1e-9;
    ClothRun run = make_run(mesh, m, o, {0.0, pins, Vec3(-g, 0, 0)});
    start(run, o);
    for (int i = 0; i < 60; ++i) run.advance();
    double bottom = 0.0;  // x coordinate of the middle of the lower end [m]
    for (Index i = 0; i < mesh.n_vertices(); ++i)
      if (base.uv()(i, 0) < 1e-9 - length / 2 && std::abs(base.uv()(i, 1)) < 1e-9)
        bottom = run.state.x(i, 0);
    INFO(degrees << " degrees: hangs " << length / 2 - bottom << ", closed form " << hang);
    // The tolerance is relative to the elongation and covers the two effects described above.
    CHECK(length / 2 - bottom - length == Approx(hang - length).epsilon(5e-3));
  }
}

TEST_CASE(
    "unknown integrators are refused with the choices, and explicit ones have no implicit "
    "options") {
  CHECK_THROWS_WITH(integrator_named("rk4"),
                    Catch::Contains("semi-implicit-euler") && Catch::Contains("\"rk4\""));
  CHECK_THROWS_AS(integrator_named("rk4"), InvalidInput);
  for (const std::string method : all_methods)
    CHECK((integrator_named(method).implicit() == nullptr) == is_explicit(method));
}
