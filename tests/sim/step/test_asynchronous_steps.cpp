// Tests of asynchronous steps in simulations: contacts, strain limits, checkpoints and refusals.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/generators.h"
#include "core/sim/model/state.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// A damped sheet of unequal triangles that hangs from two corners and falls onto a sphere.
Scene falling_sheet() {
  Scene scene;
  Cloth sheet;
  sheet.name = "sheet";
  sheet.mesh = share(jittered_grid(0.4, 0.4, 14, 14, 0.24, 3).moved(Vec3(0, 0, 0.12)));
  sheet.material.viscosity_shear = 1e-4;
  sheet.material.bending_damping = 1e-3;
  sheet.pins = {0, 14};
  scene.cloths.push_back(sheet);
  Obstacle sphere;
  sphere.name = "sphere";
  sphere.mesh = share(icosphere(0.1, 3));
  scene.obstacles.push_back(sphere);
  return scene;
}

// A sheet of 1 m x 1 m with strain limits of 0.075 that swings from two corners.
Scene limited_sheet() {
  Scene scene;
  scene.collisions = false;
  Cloth sheet;
  sheet.name = "sheet";
  sheet.mesh = share(jittered_grid(1.0, 1.0, 10, 10, 0.24, 3));
  sheet.material.weft_stiffness = sheet.material.warp_stiffness = 60.0;
  sheet.material.shear_stiffness = 30.0;
  sheet.material.density = 0.5;
  sheet.strain_limit = StrainLimit();
  sheet.strain_limit->weft = sheet.strain_limit->warp = sheet.strain_limit->shear = 0.075;
  sheet.pins = {0, 10};
  scene.cloths.push_back(sheet);
  return scene;
}

IntegratorOptions asynchronous(Schedule schedule = Schedule::Nested) {
  Asynchronous options;
  options.schedule = schedule;
  return options;
}

}  // namespace

TEST_CASE("asynchronous steps give the same bits on 1, 2, 3 and 7 threads, free of intersections") {
  const int steps = 60;
  Simulation one(falling_sheet(), asynchronous(), 1);
  std::int64_t near = 0;
  for (int i = 0; i < steps; ++i) {
    one.step();
    near += one.report().contacts.near;
  }
  CHECK(near > 20);
  CHECK(one.intersecting_pairs().empty());
  for (const int threads : {2, 3, 7}) {
    Simulation other(falling_sheet(), asynchronous(), threads);
    for (int i = 0; i < steps; ++i) other.step();
    CHECK(same(one.checkpoint(), other.checkpoint()));
  }
}

TEST_CASE("an asynchronous run continues bit for bit from a checkpoint and with rebuilt stages") {
  const Schedule schedule = GENERATE(Schedule::Nested, Schedule::Queue, Schedule::Refill);
  const double bending_multiple = GENERATE(0.0, 4.0);
  const Scene scene = falling_sheet();
  Asynchronous options;
  options.schedule = schedule, options.bending_multiple = bending_multiple;
  Simulation whole(scene, options, 1), first(scene, options, 1), second(scene, options, 2);
  for (int i = 0; i < 50; ++i) whole.step();
  for (int i = 0; i < 30; ++i) {
    first.step();
    first.rebuild_stages();
  }
  if (schedule == Schedule::Queue) {  // triangles have clocks with different phases
    const auto since = first.state().cloth.element_clocks.col(0);
    CHECK(since.maxCoeff() > 1.1 * since.minCoeff());
  }
  CAPTURE(static_cast<int>(schedule), bending_multiple);
  second.restore(first.checkpoint());
  for (int i = 0; i < 20; ++i) second.step();
  CHECK(same(whole.checkpoint(), second.checkpoint()));
}

TEST_CASE("an interval in which cloth stretches too much is taken in parts") {
  Scene scene = falling_sheet();
  scene.collisions = false;
  scene.cloths[0].material.bending_damping = 0.0;
  Simulation sim(scene, asynchronous(), 1);
  Points v = sim.velocities();
  const Points x = sim.positions();
  for (Index i = 0; i < x.rows(); ++i) v(i, 0) = 500.0 * x(i, 0);  // doubles the width in 2 ms
  sim.set_velocities(v);
  sim.step();
  CHECK(sim.report().parts > 1);
  for (int i = 0; i < 40; ++i) sim.step();
  CHECK(sim.positions().allFinite());
}

TEST_CASE("the interval of asynchronous steps is 2.5 ms unless given") {
  CHECK(Simulation(falling_sheet(), asynchronous(), 1).step_size() == 2.5e-3);
  Asynchronous automatic;
  automatic.step = Automatic();
  CHECK(Simulation(falling_sheet(), automatic, 1).step_size() == 2.5e-3);
}

TEST_CASE("strain limits have the same bits on any number of threads and after a checkpoint") {
  const Limiting limiting = GENERATE(Limiting::Potential, Limiting::Impulses);
  Asynchronous options;
  options.limiting = limiting;
  const Scene scene = limited_sheet();
  Simulation one(scene, options, 1), other(scene, options, 3);
  for (int i = 0; i < 30; ++i) one.step(), other.step();
  CHECK(same(one.checkpoint(), other.checkpoint()));
  Simulation resumed(scene, options, 2);
  resumed.restore(one.checkpoint());
  for (int i = 0; i < 20; ++i) one.step(), resumed.step();
  CHECK(same(one.checkpoint(), resumed.checkpoint()));
}

TEST_CASE("limits as a potential keep the energy in the account, limit impulses do not") {
  std::array<double, 2> lost{};
  for (const Limiting limiting : {Limiting::Potential, Limiting::Impulses}) {
    Asynchronous options;
    options.limiting = limiting;
    Simulation sim(limited_sheet(), options, 1);
    double peak = 0.0;
    for (int i = 0; i < 400; ++i) {
      sim.step();
      peak = std::max(peak, sim.report().energy.kinetic);
    }
    lost[limiting == Limiting::Impulses] = sim.report().account.lost / peak;
    CHECK(sim.report().limits.sweeps == 0);
  }
  CAPTURE(lost[0], lost[1]);
  CHECK(std::abs(lost[0]) < 0.01);
  CHECK(std::abs(lost[1]) > 0.05);
}

TEST_CASE("without limiting, strain beyond its limits is reported") {
  Asynchronous options;
  options.limiting = Limiting::None;
  Simulation sim(limited_sheet(), options, 1);
  double excess = 0.0;
  for (int i = 0; i < 200; ++i) {
    sim.step();
    excess = std::max(excess, sim.report().limits.weft_excess);
  }
  CHECK(excess > 0.1);
  CHECK(sim.report().limits.sweeps == 0);
}

TEST_CASE("options of asynchronous steps outside their limits are refused") {
  Asynchronous options;
  options.safety = 1.5;
  CHECK_THROWS_WITH(Simulation(falling_sheet(), options, 1),
                    Catch::Contains("integrator.safety must be in (0, 1] [1], got 1.5"));
  options = {};
  options.bending_multiple = -1.0;
  CHECK_THROWS_WITH(Simulation(falling_sheet(), options, 1),
                    Catch::Contains("integrator.bending_multiple must be in [0, 64] [1], got -1"));
}
