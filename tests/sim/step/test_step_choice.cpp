// Tests of automatic steps: their length in impacts, their stability, frames, checkpoints and
// targets.
#include <catch2/catch.hpp>

#include "core/mesh/generators.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// An inclined towel that falls at 4 m/s and meets the floor with its lower edge.
Scene falling_towel() {
  Scene scene;
  Cloth cloth;
  const TriangleMesh flat = grid_cells(0.18, 0.12, 12, 8);
  Points x = flat.vertices();
  for (Index i = 0; i < x.rows(); ++i) {
    const double along = x(i, 0) + 0.09;
    x.row(i) << 0.5 * along, x(i, 1), 0.1 + 0.866 * along;
  }
  cloth.mesh = share(TriangleMesh(x, flat.triangles(), flat.uv()));
  cloth.velocities = Points::Zero(x.rows(), 3);
  cloth.velocities.col(2).setConstant(-4.0);
  scene.cloths.push_back(cloth);
  Obstacle floor;
  floor.mesh = share(floor_square(2.0, 4));
  scene.obstacles.push_back(floor);
  return scene;
}

IntegratorOptions automatic(std::string_view method = "semi-implicit-euler") {
  return integrator_named(method);
}

}  // namespace

TEST_CASE("automatic steps are short in an impact and long before and after it") {
  Simulation sim(falling_towel(), automatic(), 1);
  double shortest = 1.0, longest = 0.0, time = 0.0;
  while (sim.time() < 0.8) {
    sim.step();
    const StepReport& report = sim.report();
    CHECK(report.time == Approx(time + report.length).epsilon(1e-12));
    time = report.time;
    shortest = std::min(shortest, report.length);
    longest = std::max(longest, report.length);
    CHECK(report.strain.stretch < 1.2);
  }
  CHECK(longest == 10e-3);
  CHECK(longest > 8.0 * shortest);
}

TEST_CASE("automatic steps have the same bits on two threads and after a checkpoint") {
  for (const char* method : {"semi-implicit-euler", "bdf2", "implicit-midpoint"}) {
    CAPTURE(method);
    Simulation one(falling_towel(), automatic(method), 1),
        two(falling_towel(), automatic(method), 2), resumed(falling_towel(), automatic(method), 1);
    for (int i = 0; i < 40; ++i) {
      one.step();
      two.step();
      if (i == 19) resumed.restore(one.checkpoint());
      if (i > 19) resumed.step();
    }
    CHECK(one.time() == resumed.time());
    CHECK(same(one.checkpoint(), two.checkpoint()));
    CHECK(same(one.checkpoint(), resumed.checkpoint()));
  }
}

TEST_CASE("frames lie between automatic steps, and do not change them") {
  Simulation seen(falling_towel(), automatic(), 1), unseen(falling_towel(), automatic(), 1);
  for (int i = 0; i < 30; ++i) {
    const double before = seen.time();
    seen.step();
    unseen.step();
    const Frame frame = seen.frame_at(0.5 * (before + seen.time()));
    CHECK(frame.time == Approx(0.5 * (before + seen.time())));
    CHECK_THROWS_AS(seen.frame_at(before - 1e-3), InvalidInput);
  }
  CHECK(same(seen.checkpoint(), unseen.checkpoint()));
}

TEST_CASE("automatic steps need an accuracy") {
  IntegratorOptions options = automatic();
  options.implicit()->accuracy.reset();
  CHECK_THROWS_WITH(Simulation(falling_towel(), options, 1),
                    Catch::Contains("integrator.accuracy must be a number"));
}

TEST_CASE("automatic steps of symplectic Euler are stable") {
  Scene scene = falling_towel();
  scene.obstacles.clear();
  scene.gravity.setZero();
  Simulation sim(scene, automatic("symplectic-euler"), 1);
  const double before = sim.report().energy.kinetic;
  const double h = sim.step_size();
  CHECK(h < 1e-3);
  for (int i = 0; i < 300; ++i) sim.step();
  CHECK(sim.report().energy.kinetic == Approx(before).epsilon(1e-6));
}

TEST_CASE("a restored simulation forgets what the user wrote before") {
  Simulation kept(falling_towel(), automatic(), 1), written(falling_towel(), automatic(), 1);
  for (int i = 0; i < 10; ++i) kept.step(), written.step();
  const Checkpoint start = kept.checkpoint();
  written.set_positions(written.positions().array() + 0.01);
  written.restore(start);
  for (int i = 0; i < 10; ++i) kept.step(), written.step();
  CHECK(same(kept.checkpoint(), written.checkpoint()));
}

TEST_CASE("targets set by the user are reached after the largest step, at a constant velocity") {
  Scene scene = falling_towel();
  scene.obstacles.clear();
  scene.cloths[0].velocities.resize(0, 3);
  scene.cloths[0].pins = {0, 12};
  Simulation sim(scene, automatic(), 1);
  for (int i = 0; i < 5; ++i) sim.step();
  Points targets = sim.positions();
  const double start = sim.time();
  targets.col(2).array() += 0.05;
  sim.set_pin_targets(targets);
  while (sim.time() < start + sim.step_size() - 1e-12) {
    sim.step();
    // The pins move 0.05 m within 10 ms, the largest length of a step, so their speed is 5 m/s.
    // Only the last step may end after these 10 ms, and its mean velocity is then lower.
    CHECK(std::abs(sim.velocities()(0, 2)) < 5.1);
  }
  CHECK((sim.positions().row(0) - targets.row(0)).norm() == 0.0);
}
