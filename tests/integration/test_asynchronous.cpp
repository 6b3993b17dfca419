// Tests of the asynchronous integrator (see "Asynchronous steps" in docs/method.md).
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/integration/asynchronous/element_steps.h"
#include "core/integration/asynchronous/event_queue.h"
#include "core/integration/asynchronous/nested_steps.h"
#include "tests/support/cloth_fixture.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// Two springs on a line. The first connects the fixed point x = 0 with a vertex that starts at 1 m.
// The second connects this vertex with another one, which starts at 2 m.
struct Springs {
  std::array<double, 2> mass = {2.0, 1.0}, x = {1.0, 2.0}, v = {0.0, 0.0};

  // Returns the forces on the two vertices [N]: the force of a spring, and gravity on the mass of 1
  // kg that the spring contributes to each of its vertices.
  std::array<double, 2> force_of(int spring) const {
    const double gravity = -10.0;
    if (spring == 0) return {-100.0 * (x[0] - 1.0) + gravity, 0.0};
    const double tension = 50.0 * (x[1] - x[0] - 1.0);
    return {tension + gravity, -tension + gravity};
  }
};

struct NestedChain : Springs {
  std::array<double, 2> step;  // step of each level [s]
  std::array<int, 2> level;    // level of each spring
  std::array<std::array<double, 2>, 2> force = {};

  void measure(int first, bool) {
    for (int k = 0; k < 2; ++k)
      if (level[k] >= first) force[k] = force_of(k);
  }
  void kick(int first, bool half) {
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < 2; ++k)
        if (level[k] >= first) v[i] += (half ? 0.5 : 1.0) * step[level[k]] * force[k][i] / mass[i];
  }
  void drift(int first, Index) {
    const std::array<int, 2> finest = {std::max(level[0], level[1]), level[1]};
    for (int i = 0; i < 2; ++i)
      if (finest[i] >= first) x[i] += step[finest[i]] * v[i];
  }
};

struct QueueChain : Springs {
  std::array<double, 2> steps;  // step of each spring [s]
  std::array<double, 2> time = {0.0, 0.0};
  std::vector<std::pair<Index, double>> events = {};

  double step(Index spring) const { return steps[spring]; }
  void move_vertex(int i, double to) { x[i] += (to - time[i]) * v[i], time[i] = to; }
  void move(Index spring, double to) {
    move_vertex(0, to);
    if (spring == 1) move_vertex(1, to);
    events.emplace_back(spring, to);
  }
  void kick(Index spring, double duration) {
    const std::array<double, 2> force = force_of(spring);
    for (int i = 0; i < 2; ++i) v[i] += duration * force[i] / mass[i];
  }
};

ClothMaterial stiff() {
  ClothMaterial m;
  m.weft_stiffness = 300, m.warp_stiffness = 200, m.shear_stiffness = 100, m.poisson = 0.2,
  m.density = 0.5;
  return m;
}

Asynchronous options_of(double interval, double multiple = 4.0) {
  Asynchronous options;
  options.step = interval;
  options.bending_multiple = multiple;
  return options;
}

// A grid whose cells become wider along one axis.
TriangleMesh graded() {
  const TriangleMesh mesh = jittered_grid(0.6, 0.4, 12, 8, 0.2, 5);
  Points x = mesh.vertices();
  const auto narrow = [](double s) { return s * (1.0 + 1.6 * s); };
  for (Index i = 0; i < x.rows(); ++i) x(i, 0) = narrow(x(i, 0) + 0.31);
  return {x, mesh.triangles()};
}

// A sheet that is stretched in its plane and bent. It rotates and translates.
ClothRun spinning_sheet(const TriangleMesh& mesh, const Asynchronous& options, double bending,
                        const ClothMaterial& material = stiff()) {
  ClothRun run = make_run(mesh, material, options, {bending});
  for (Index i = 0; i < mesh.n_vertices(); ++i) {
    const Vec3 x(1.05 * mesh.vertices()(i, 0), 1.05 * mesh.vertices()(i, 1),
                 0.02 * std::sin(12.0 * mesh.vertices()(i, 0)));
    run.state.x.row(i) = x.transpose();
    run.state.v.row(i) = (Vec3(1, 2, 6).cross(x) + Vec3(0.3, 0, 0.1)).transpose();
  }
  return run;
}

}  // namespace

TEST_CASE("two springs with nested steps move as computed by hand") {
  // Steps of 0.05 and 0.1 s in an interval of 0.2 s. The values are exact up to the rounding of the
  // decimal fractions 0.05 and 0.1.
  NestedChain chain{{}, {0.1, 0.05}, {1, 0}};
  take_nested_steps(2, 1, chain);
  CHECK(chain.x[0] == Approx(0.8319091796875).epsilon(1e-14));
  CHECK(chain.x[1] == Approx(1.801171875).epsilon(1e-14));
}

TEST_CASE("two springs in a queue move as computed by hand, also over two intervals") {
  for (const int parts : {1, 2}) {
    for (const double outer : {0.1, 0.08}) {
      QueueChain chain{{}, {0.05, outer}};
      Points2 clocks(2, 2);
      clocks << 0.0, 0.05, 0.0, outer;
      for (int part = 0; part < parts; ++part) {
        const double interval = 0.2 / parts;
        take_events(interval, chain, clocks);
        chain.move_vertex(0, interval), chain.move_vertex(1, interval);
        chain.time = {0.0, 0.0};
      }
      CAPTURE(parts, outer);
      // The values are exact up to the rounding of the steps, which are decimal fractions.
      CHECK(chain.x[0] == Approx(outer == 0.1 ? 0.888671875 : 0.875976375).epsilon(1e-14));
      CHECK(chain.x[1] == Approx(outer == 0.1 ? 1.89375 : 1.8676285).epsilon(1e-14));
      if (outer != 0.08 || parts != 1) continue;
      std::vector<Index> order;
      for (const auto& event : chain.events) order.push_back(event.first);
      CHECK(order == std::vector<Index>{0, 1, 0, 0, 1, 0});
    }
  }
}

TEST_CASE("with equal steps, nested steps are those of leapfrog") {
  const TriangleMesh mesh = jittered_grid(0.3, 0.3, 5, 5, 0.2, 3);
  const double h = 2e-4;  // below the longest stable step of every triangle
  const Vec3 gravity(0, 0, -9.81);
  for (const std::string element : {"mid-edge", "hinge"}) {
    for (const double multiple : {0.0, 4.0}) {
      const Asynchronous options = options_of(h, multiple);
      ClothRun run = make_run(mesh, stiff(), options, {1e-5, {0}, gravity, element});
      start(run, options);
      Points x = run.state.x, v = run.state.v;
      const auto kick = [&] {
        Points force = run.force;
        run.elasticity->add_implicit_forces({}, x, nullptr, 0, run.model.n_vertices, force);
        run.elasticity->add_explicit_bending({}, x, v, 0, run.model.n_vertices, force);
        for (Index i = 1; i < x.rows(); ++i) v.row(i) += 0.5 * h / run.model.mass[i] * force.row(i);
      };
      for (int i = 0; i < 100; ++i) {
        run.advance();
        kick();
        x += h * v;
        kick();
      }
      CAPTURE(element, multiple);
      // The tolerance allows for rounding in 100 steps, in which the sheet falls by 2 mm.
      CHECK((run.state.x - x).cwiseAbs().maxCoeff() < 1e-14);
    }
  }
}

TEST_CASE("with equal steps, the queue is symplectic Euler that moves vertices first") {
  const TriangleMesh mesh = grid_cells(0.3, 0.3, 6, 6);
  Asynchronous options = options_of(1.0, 0.0);
  options.schedule = Schedule::Queue;
  ClothRun run = make_run(mesh, stiff(), options, {1e-5, {0}, Vec3(0, 0, -9.81)});
  const ElementSteps steps(run.model, options);
  // The triangles of a grid have equal steps up to rounding. The interval is slightly longer than
  // these steps, so that each triangle has one event in each interval.
  const double h = steps.at_rest().maxCoeff();
  REQUIRE(steps.at_rest().minCoeff() == Approx(h).epsilon(1e-12));
  run.step = h * (1.0 + 1e-9);
  start(run, options);
  Points x = run.state.x, v = run.state.v;
  for (int i = 0; i < 20; ++i) {
    run.advance();
    x += h * v;
    Points force = run.force;
    run.elasticity->add_implicit_forces({}, x, nullptr, 0, run.model.n_vertices, force);
    run.elasticity->add_explicit_bending({}, x, v, 0, run.model.n_vertices, force);
    for (Index k = 1; k < x.rows(); ++k) v.row(k) += h / run.model.mass[k] * force.row(k);
    // The tolerance allows for intervals that are longer than the steps by a factor of 1 + 1e-9.
    REQUIRE((run.state.x - x).cwiseAbs().maxCoeff() < 1e-8);
  }
}

TEST_CASE("the queue keeps the energy of a swinging sheet better than intervals that refill it") {
  const Vec3 gravity(0, 0, -9.81);
  const auto error = [&](Schedule schedule) {
    Asynchronous options = options_of(2.5e-3);
    options.schedule = schedule, options.safety = 0.2;
    ClothRun run =
        make_run(jittered_grid(1.0, 1.0, 6, 6, 0.24, 7), stiff(), options, {1e-5, {0, 6}, gravity});
    start(run, options);
    const double begin = run.energy();
    double peak = 0.0, largest = 0.0;
    for (int i = 0; i < 800 && largest <= peak; ++i) {
      run.advance();
      peak = std::max(peak, run.kinetic_energy());
      largest = std::max(largest, std::abs(run.energy() - begin));
    }
    return largest / peak;
  };
  const double queue = error(Schedule::Queue), refill = error(Schedule::Refill);
  CAPTURE(queue, refill);
  CHECK(queue < 0.05);  // first-order error: the motion lags by half a step
  CHECK(refill > 2.0 * queue);
}

TEST_CASE("nested steps are of order 2 on a graded mesh") {
  const auto end = [](double safety) {
    Asynchronous options = options_of(2.5e-3);
    options.safety = safety;
    ClothRun run = spinning_sheet(graded(), options, 1e-5);
    start(run, options);
    for (int i = 0; i < 20; ++i) run.advance();
    return run.state.x;
  };
  const Points a = end(0.2), b = end(0.1), c = end(0.05);
  const double order = std::log2((a - b).norm() / (b - c).norm());
  INFO("order " << order);
  CHECK(order == Approx(2.0).margin(0.3));
}

TEST_CASE("nested steps keep linear and angular momentum to rounding") {
  const Asynchronous options = options_of(2.5e-3);
  ClothRun run = spinning_sheet(graded(), options, 1e-4);
  start(run, options);
  const auto momenta = [&] {
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
    for (Index i = 0; i < run.model.n_vertices; ++i) {
      const Vec3 p = run.model.mass[i] * run.state.v.row(i).transpose();
      sum.head<3>() += p;
      sum.tail<3>() += Vec3(run.state.x.row(i).transpose()).cross(p);
    }
    return sum;
  };
  const auto before = momenta();
  for (int i = 0; i < 40; ++i) run.advance();
  // The tolerance allows for rounding in 40 intervals. Internal impulses, which cancel in the total
  // momentum, are much larger than this momentum.
  CHECK((momenta() - before).norm() < 1e-11 * before.norm());
}

TEST_CASE("energy of a swinging sheet does not drift with nested steps") {
  const TriangleMesh mesh = jittered_grid(1.0, 1.0, 8, 8, 0.24, 7);
  const Asynchronous options = options_of(2.5e-3);
  ClothRun run = make_run(mesh, stiff(), options, {1e-5, {0, 8}, Vec3(0, 0, -9.81)});
  start(run, options);
  const double begin = run.energy();
  double peak = 0.0, middle = 0.0, last = 0.0;
  const int n = 4000, tenth = n / 10;  // n intervals last 10 s
  for (int i = 0; i < n; ++i) {
    run.advance();
    peak = std::max(peak, run.kinetic_energy());
    const double e = run.energy() - begin;
    if (i >= n * 9 / 20 && i < n * 11 / 20) middle += e / tenth;
    if (i >= n * 9 / 10) last += e / tenth;
  }
  CAPTURE(peak, middle / peak, last / peak);
  // The energy error of leapfrog oscillates with the motion and does not grow.
  CHECK(std::abs(last) < 0.01 * peak);
  CHECK(std::abs(last - middle) < 0.005 * peak);
}

TEST_CASE("nested steps have the same bits on any number of threads") {
  Points results[2];
  for (const int threads : {1, 3}) {
    const Asynchronous options = options_of(2.5e-3);
    ClothMaterial material = stiff();
    material.viscosity_shear = 1e-4;
    ClothRun run =
        spinning_sheet(jittered_grid(0.6, 0.6, 24, 24, 0.24, 5), options, 1e-5, material);
    start(run, options);
    const OwnRows loads(run.force);
    for (int i = 0; i < 10; ++i) {
      StepInputs in;
      in.step = run.step, in.time = i * run.step;
      in.force = &loads, in.fixed = &run.fixed, in.target = &run.target;
      in.body_mass = &run.body_mass;
      run.integrator->advance(Team{threads}, *run.layout, in, run.state, run.bodies);
    }
    results[threads == 3] = run.state.x;
  }
  CHECK(results[0] == results[1]);
}

TEST_CASE("the step of a triangle on its own is the limit of stability, at rest and below it") {
  Asynchronous options = options_of(2.5e-3);
  options.safety = 1.0;
  Triangles one(1, 3);
  one << 0, 1, 2;
  // An equilateral triangle, a needle and a cap.
  for (const std::array<double, 2>& apex : {std::array{0.05, 0.0866}, {0.05, 0.4}, {0.05, 0.01}}) {
    Points corners(3, 3);
    corners << 0, 0, 0, 0.1, 0, 0, apex[0], apex[1], 0;
    for (const double viscosity : {0.0, 1e-3}) {
      ClothMaterial material = stiff();
      material.viscosity_shear = viscosity;
      const TriangleMesh mesh(corners, one);
      ClothRun run = make_run(mesh, material, options);
      start(run, options);
      ElementSteps steps(run.model, options);
      const double limit = stable_step_at(run.model, run.state.x);
      CAPTURE(apex[1], viscosity);
      // The tolerance covers errors of `limit` from power iteration and central differences.
      if (viscosity == 0.0) CHECK(steps.at_rest()[0] == Approx(limit).epsilon(1e-5));
      CHECK(steps.at_rest()[0] < limit * (1 + 1e-5));
      Points x = run.state.x;
      x.col(0) *= 1.6, x.col(1) *= 1.2;
      x.col(0) += 0.3 * x.col(1);
      CHECK(steps.at({}, x, Points::Zero(x.rows(), 3), *run.elasticity)[0] <
            stable_step_at(run.model, x) * (1 + 1e-5));
    }
  }
}

TEST_CASE("the step of the inradius rule is that of (4.26)") {
  Asynchronous options = options_of(2.5e-3);
  options.limit = StepLimit::Inradius;
  ClothMaterial material;
  material.weft_stiffness = material.warp_stiffness = 300, material.poisson = 0.2;
  material.shear_stiffness = 300 / (2 * 1.2), material.density = 0.5;  // isotropic
  Points corners(3, 3);
  corners << 0, 0, 0, 0.3, 0, 0, 0, 0.4, 0;  // inradius 0.1 m
  Triangles one(1, 3);
  one << 0, 1, 2;
  const ClothRun run = make_run(TriangleMesh(corners, one), material, options);
  const double wave = 300 / (1 - 0.2 * 0.2);  // lambda + 2 mu in plane stress [N/m]
  // Waves in isotropic cloth are equally fast in all directions.
  CHECK(ElementSteps(run.model, options).at_rest()[0] ==
        Approx(0.6 * 0.1 * std::sqrt(0.5 / wave)).epsilon(1e-3));
}

TEST_CASE("viscosity and damped bending of any strength take energy and stay stable") {
  const Schedule schedule = GENERATE(Schedule::Nested, Schedule::Queue);
  const double multiple = GENERATE(0.0, 4.0);
  for (const double viscosity : {1e-2, 1.0}) {
    ClothMaterial material = stiff();
    material.viscosity_dilation = material.viscosity_shear = viscosity;
    Asynchronous options = options_of(2.5e-3, multiple);
    options.schedule = schedule;
    ClothRun run = spinning_sheet(graded(), options, 1e-5, material);
    for (auto& part : run.model.bending) part.damping = 0.1 * viscosity;
    start(run, options);
    double e = run.energy();
    const double begin = e;
    for (int i = 0; i < 8; ++i) {
      run.advance();
      const double next = run.energy();
      CHECK(next < e + 1e-3 * begin);
      e = next;
    }
    CAPTURE(viscosity, multiple, static_cast<int>(schedule));
    CHECK(e < 0.99 * begin);
  }
}

TEST_CASE("a damped queue takes as much energy as damped nested steps") {
  ClothMaterial material = stiff();
  material.viscosity_shear = 1e-2;
  std::vector<double> lost;
  for (const Schedule schedule : {Schedule::Nested, Schedule::Queue}) {
    Asynchronous options = options_of(2.5e-3);
    options.schedule = schedule, options.safety = 0.1;
    ClothRun run = spinning_sheet(graded(), options, 1e-4, material);
    for (auto& part : run.model.bending) part.damping = 1e-2;
    start(run, options);
    const double begin = run.energy();
    for (int i = 0; i < 20; ++i) run.advance();
    lost.push_back(1.0 - run.energy() / begin);
  }
  CAPTURE(lost[0], lost[1]);
  CHECK(lost[0] > 0.02);
  CHECK(lost[1] == Approx(lost[0]).epsilon(0.02));  // the motion in a queue lags by half a step
}

TEST_CASE("triangles that stretch take shorter steps, and never longer ones again") {
  const Asynchronous options = options_of(2.5e-3);
  ClothRun run = make_run(graded(), stiff(), options);
  start(run, options);
  run.advance();
  const Vector rest = run.state.element_steps;
  const Points still = run.state.x;
  run.state.x *= 1.3;
  run.advance();
  const Vector stretched = run.state.element_steps;
  CHECK((stretched.array() < 0.8 * rest.array()).all());
  run.state.x = still;
  run.advance();
  CHECK(run.state.element_steps == stretched);
}

TEST_CASE("a step in which cloth stretches beyond the limit of stability fails") {
  const Asynchronous options = options_of(2.5e-3);
  ClothRun run = make_run(graded(), stiff(), options);
  start(run, options);
  run.state.v = 2000.0 * run.state.x;  // would stretch the sheet sixfold in a step
  CHECK_THROWS_WITH(run.advance(), Catch::Contains("lower integrator.step"));
}
