// Tests of strain limits in asynchronous steps (see "Asynchronous steps" in docs/method.md).
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/cloth/limit_potential.h"
#include "core/integration/asynchronous/element_steps.h"
#include "tests/support/cloth_fixture.h"
#include "tests/support/decompositions.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// The material of the swinging sheet in docs/experiments/strain_limits.md, "Limits in asynchronous
// steps".
ClothMaterial swinging() {
  ClothMaterial m;
  m.weft_stiffness = m.warp_stiffness = 300, m.shear_stiffness = 150, m.density = 0.5;
  return m;
}

StrainLimit limit_of(double most) {
  StrainLimit limit;
  limit.weft = limit.warp = limit.shear = most;
  return limit;
}

void set_limit(ClothRun& run, const StrainLimit& limit, bool by_edges = false) {
  run.model.strain_limits = {limit};
  run.model.strain_limit_of.assign(run.model.triangles.rows(), 0);
  run.model.limited_by_edges = by_edges;
}

double longest_edge(const ClothRun& run) {
  double longest = 0.0;
  for (Index t = 0; t < run.model.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      const double rest = (run.model.corners[t].row(next) - run.model.corners[t].row(k)).norm();
      const auto a = run.state.x.row(run.model.triangles(t, k));
      const auto b = run.state.x.row(run.model.triangles(t, next));
      longest = std::max(longest, (b - a).norm() / rest);
    }
  return longest;
}

struct Swing {
  double stretch = 0.0, edge = 0.0;  // largest stretch of triangles and of edges
  // Energy gained since the start, averaged over the last tenth of the time and divided by the
  // largest kinetic energy.
  double gain = 0.0;
};

// Simulates 4 s of a square sheet of 2 m that is pinned at two corners and released flat.
Swing swing(const Asynchronous& options, const StrainLimit& limit, bool by_edges = false) {
  const TriangleMesh mesh = jittered_grid(2.0, 2.0, 16, 16, 0.24, 5);
  ClothRun run = make_run(mesh, swinging(), options, {1e-5, {0, 16}, Vec3(0, 0, -9.81)});
  set_limit(run, limit, by_edges);
  start(run, options);
  const double begin = run.potential_energy();
  const int steps = 1600, tenth = 160;
  double peak = 0.0, sum = 0.0;
  Swing found;
  Points green;
  Vector stretch;
  for (int i = 0; i < steps; ++i) {
    run.advance();
    run.elasticity->strain({}, run.state.x, green, stretch);
    found.stretch = std::max(found.stretch, stretch.maxCoeff());
    found.edge = std::max(found.edge, longest_edge(run));
    peak = std::max(peak, run.kinetic_energy());
    if (i >= steps - tenth) sum += run.energy() - begin;
  }
  found.gain = sum / tenth / peak;
  return found;
}

Asynchronous limiting(Limiting method, Schedule schedule = Schedule::Nested) {
  Asynchronous options;
  options.limiting = method;
  options.schedule = schedule;
  return options;
}

Membrane limited_membrane(const ClothRun& run) {
  Membrane membrane(run.model.n_vertices, run.model.triangles, run.model.corners.all(),
                    {run.model.constants, run.model.first_triangle});
  membrane.add_limits(limit_potential(run.model, {}));
  return membrane;
}

Points force_at(Membrane& membrane, const Points& x) {
  Points force = Points::Zero(x.rows(), 3);
  membrane.add_forces({}, x, nullptr, 0, static_cast<Index>(x.rows()), force);
  return force;
}

// A triangle that is stretched and sheared. With the stretches that the tests use, its strains
// reach all three phases of the membrane (LimitMode in core/cloth/membrane/limit_modes.h).
ClothRun stretched_triangle(const Asynchronous& options, double stretch, bool by_edges) {
  Points corners(3, 3);
  corners << 0, 0, 0, 0.05, 0.01, 0, 0.01, 0.06, 0;
  Triangles triangles(1, 3);
  triangles << 0, 1, 2;
  ClothRun run = make_run({corners, triangles}, swinging(), options);
  StrainLimit limit = limit_of(0.05);
  limit.weft_min = -0.02, limit.shear_min = -0.03;
  set_limit(run, limit, by_edges);
  run.state.x.col(0) = corners.col(0) * (1.0 + stretch) + 0.5 * stretch * corners.col(1);
  run.state.x.col(1) = corners.col(1) * (1.0 - stretch);
  run.state.x.col(2) = 0.02 * corners.col(0);
  start(run, options);
  return run;
}

}  // namespace

TEST_CASE("limits as a potential hold a swinging sheet and keep its energy") {
  const Swing free = swing(limiting(Limiting::None), limit_of(0.075));
  CHECK(free.stretch > 1.5);
  const Swing limited = swing(limiting(Limiting::Potential), limit_of(0.075));
  CAPTURE(limited.stretch, limited.gain);
  CHECK(limited.stretch <= 1.25);
  CHECK(std::abs(limited.gain) <= 0.003);
  // If the option `predicted` is given, it replaces the upper limits of the cloth.
  Asynchronous given = limiting(Limiting::Potential);
  given.predicted = 0.075;
  CHECK(swing(given, limit_of(0.5)).stretch == limited.stretch);
}

TEST_CASE("limits along edges as a potential hold edges and keep energy") {
  const Swing limited = swing(limiting(Limiting::Potential), limit_of(0.075), true);
  CAPTURE(limited.edge, limited.gain);
  CHECK(limited.edge <= 1.2);
  CHECK(std::abs(limited.gain) <= 0.003);
}

TEST_CASE("limits by impulses hold a swinging sheet and take its energy") {
  const bool by_edges = GENERATE(false, true);
  const Schedule schedule = GENERATE(Schedule::Nested, Schedule::Queue);
  const Swing limited = swing(limiting(Limiting::Impulses, schedule), limit_of(0.075), by_edges);
  CAPTURE(by_edges, static_cast<int>(schedule), limited.stretch, limited.gain);
  // Without limits, the stretch exceeds 1.5 (see the first test).
  CHECK(limited.stretch <= 1.35);
  CHECK(limited.gain < -0.1);
}

TEST_CASE("forces of a limited membrane are the negative gradient of its energy") {
  const bool by_edges = GENERATE(false, true);
  for (const double stretch : {0.03, 0.06, 0.2, -0.04, -0.3}) {
    const ClothRun run = stretched_triangle(limiting(Limiting::Potential), stretch, by_edges);
    Membrane membrane = limited_membrane(run);
    const Points force = force_at(membrane, run.state.x);
    for (int i = 0; i < 9; ++i) {
      // The tolerance covers the errors of the difference quotient.
      const double d = 1e-7;  // [m]
      Points above = run.state.x, below = run.state.x;
      above.data()[i] += d, below.data()[i] -= d;
      const double slope = (membrane.energy({}, above) - membrane.energy({}, below)) / (2.0 * d);
      CAPTURE(by_edges, stretch, i);
      CHECK(force.data()[i] == Approx(-slope).epsilon(1e-5).margin(1e-4));
    }
  }
}

TEST_CASE("the step of a limited triangle is at most the limit of stability in every phase") {
  const bool by_edges = GENERATE(false, true);
  Asynchronous options = limiting(Limiting::Potential);
  options.safety = 1.0;
  double shortest = 1.0;
  for (const double stretch : {0.0, 0.03, 0.06, 0.2, -0.04, -0.3}) {
    ClothRun run = stretched_triangle(options, stretch, by_edges);
    Membrane membrane = limited_membrane(run);
    Eigen::Matrix<double, 9, 9> stiffness;
    for (int i = 0; i < 9; ++i) {
      Points above = run.state.x, below = run.state.x;
      above.data()[i] += 1e-7, below.data()[i] -= 1e-7;
      const Points slope = (force_at(membrane, below) - force_at(membrane, above)) / 2e-7;
      for (int k = 0; k < 9; ++k) stiffness(k, i) = slope.data()[k] / run.model.mass[0];
    }
    const double largest = test::eigenvalues(0.5 * (stiffness + stiffness.transpose()))[8];
    ElementSteps steps(run.model, options, limit_potential(run.model, {}));
    const Points still = Points::Zero(3, 3);
    const double step = steps.at({}, run.state.x, still, *run.elasticity)[0];
    CAPTURE(by_edges, stretch);
    CHECK(step <= 2.0 / std::sqrt(largest) * (1.0 + 1e-5));  // tolerance: error of `stiffness`
    CHECK(step >= 0.6 * 2.0 / std::sqrt(largest));
    shortest = std::min(shortest, step / steps.at_rest()[0]);
  }
  CHECK(shortest < 0.15);
}

TEST_CASE("the strain of a limited triangle changes by at most 0.1 in a step") {
  const Asynchronous options = limiting(Limiting::Potential);
  ClothRun run = make_run(jittered_grid(0.6, 0.4, 6, 4, 0.2, 5), swinging(), options);
  set_limit(run, limit_of(10.0));
  const double rate = 1000.0;  // [1/s]
  run.state.v.col(0) = rate * run.state.x.col(0);
  start(run, options);
  ElementSteps steps(run.model, options, limit_potential(run.model, {}));
  const Vector at = steps.at({}, run.state.x, run.state.v, *run.elasticity);
  CHECK(steps.at_rest().maxCoeff() * rate > 0.2);
  CHECK(at.maxCoeff() * rate <= 0.1);
}

TEST_CASE("limits keep linear momentum to rounding, and as a potential angular momentum") {
  const Limiting method = GENERATE(Limiting::Potential, Limiting::Impulses);
  const bool by_edges = GENERATE(false, true);
  const Asynchronous options = limiting(method);
  ClothRun run = make_run(jittered_grid(0.6, 0.4, 12, 8, 0.2, 5), swinging(), options, {1e-4});
  set_limit(run, limit_of(0.02), by_edges);
  for (Index i = 0; i < run.model.n_vertices; ++i) {
    const Vec3 x = 1.05 * run.state.x.row(i).transpose();
    run.state.x.row(i) = x.transpose();
    run.state.v.row(i) = (Vec3(1, 2, 6).cross(x) + Vec3(0.3, 0, 0.1)).transpose();
  }
  start(run, options);
  const auto momenta = [&] {
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
    for (Index i = 0; i < run.model.n_vertices; ++i) {
      const Vec3 x = run.state.x.row(i).transpose();
      const Vec3 p = run.model.mass[i] * run.state.v.row(i).transpose();
      sum.head<3>() += p, sum.tail<3>() += x.cross(p);
    }
    return sum;
  };
  const auto before = momenta();
  for (int i = 0; i < 40; ++i) run.advance();
  CHECK((momenta() - before).head<3>().norm() < 1e-12 * before.norm());
  if (method == Limiting::Potential)
    CHECK((momenta() - before).tail<3>().norm() < 1e-12 * before.norm());
}

namespace {

// A triangle with two edges of 5 cm that enclose `angle` [rad], with limits of 7.5 % on its edges.
ClothRun triangle_with_angle(double angle) {
  Points corners = Points::Zero(3, 3);
  corners(1, 0) = 0.05;
  corners.row(2) << 0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.0;
  Triangles triangles(1, 3);
  triangles << 0, 1, 2;
  const Asynchronous options = limiting(Limiting::Potential);
  ClothRun run = make_run({corners, triangles}, swinging(), options);
  set_limit(run, limit_of(0.075), true);
  start(run, options);
  return run;
}

double stretch_of(const ClothRun& run) {
  Points green;
  Vector stretch;
  run.elasticity->strain({}, run.state.x, green, stretch);
  return stretch[0];
}

}  // namespace

TEST_CASE("limits of edges bound the stretch of a triangle only by its largest angle") {
  for (const double degrees : {60.0, 75.0, 90.0, 120.0}) {
    CAPTURE(degrees);
    const double angle = degrees * M_PI / 180.0, bound = 1.075 / std::cos(0.5 * angle);
    ClothRun run = triangle_with_angle(angle);
    // The two edges that enclose the angle are stretched to just below their limit and lie almost
    // on one line. The third edge is much shorter than at rest. No edge exceeds its limit, so
    // the limits cause no force.
    const double length = 0.05 * 1.0749;
    Points& x = run.state.x;
    x.setZero();
    for (const int i : {1, 2}) x.row(i) << length, (i == 1 ? 1e-3 : -1e-3) * length, 0.0;
    CHECK(stretch_of(run) > 0.999 * bound);
    Membrane limited = limited_membrane(run);
    Membrane free(3, run.model.triangles, run.model.corners.all(), run.model.constants);
    CHECK(force_at(limited, x) == force_at(free, x));
    // Random positions within the limits of the edges do not stretch the triangle beyond the bound.
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-0.1, 0.1);
    int n_allowed = 0;
    for (int i = 0; i < 20000; ++i) {
      for (Index k = 1; k < 3; ++k) x.row(k) << place(random), place(random), 0.0;
      if (longest_edge(run) > 1.075) continue;
      ++n_allowed;
      CHECK(stretch_of(run) < bound * (1.0 + 1e-9));
    }
    CHECK(n_allowed > 100);
  }
}
