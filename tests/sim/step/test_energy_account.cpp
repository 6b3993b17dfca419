// Claims about the account of energy.
#include <catch2/catch.hpp>

#include "core/mesh/generators.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// A sheet held along one edge.
Scene sheet() {
  Scene scene;
  Cloth cloth;
  cloth.mesh = share(grid_cells(0.2, 0.2, 8, 8));
  const Points& x = cloth.mesh->vertices();
  for (Index i = 0; i < x.rows(); ++i)
    if (x(i, 0) == x.col(0).minCoeff()) cloth.pins.push_back(i);
  scene.cloths.push_back(cloth);
  return scene;
}

// The sheet of `scene`, whose held edge is drawn along the motion [m] in 0.2 s, and back.
Scene drawn(Scene scene, const Vec3& motion) {
  Cloth& cloth = scene.cloths[0];
  const Index n = static_cast<Index>(cloth.pins.size());
  cloth.script_times = {0.0, 0.2, 0.4};
  cloth.script_positions.resize(3 * n, 3);
  for (const Index time : {0, 1, 2})
    for (Index i = 0; i < n; ++i)
      cloth.script_positions.row(time * n + i) =
          cloth.mesh->vertices().row(cloth.pins[i]) + (time == 1 ? 1.0 : 0.0) * motion.transpose();
  return scene;
}

// Largest distance of the balance from 0 in 0.4 s.
double imbalance(const Scene& scene, const IntegratorOptions& options) {
  Simulation sim(scene, options, 1);
  double most = 0.0;
  while (sim.time() < 0.4 - 1e-9) {
    sim.step();
    most = std::max(most, std::abs(sim.report().account.balance));
  }
  return most;
}

}  // namespace

TEST_CASE("without losses, energy less work stays what it was, the better the shorter the steps") {
  const auto midpoint = [](double h) {
    IntegratorOptions options = step_of(h, "nonlinear-midpoint");
    options.implicit()->jacobian = JacobianKind::Exact;
    return options;
  };
  // The held edge stays, is drawn along the sheet, and is moved across it.
  for (const Scene& scene :
       {sheet(), drawn(sheet(), Vec3(-0.03, 0, 0)), drawn(sheet(), Vec3(0, 0, 0.1))}) {
    const double coarse = imbalance(scene, midpoint(2e-3)), fine = imbalance(scene, midpoint(5e-4));
    CAPTURE(coarse, fine);
    // The velocity of the edge jumps twice, where the scheme is of first order.
    CHECK(fine < 0.03);
    CHECK(fine < coarse / 4.0);
  }
}

TEST_CASE("implicit Euler loses energy in the account, and never gains any") {
  for (const Scene& scene : {sheet(), drawn(sheet(), Vec3(0, 0, 0.1))}) {
    Simulation sim(scene, step_of(4e-3), 1);
    for (int i = 0; i < 100; ++i) {
      sim.step();
      CHECK(sim.report().account.balance < 0.01);
    }
    CHECK(sim.report().account.lost > 0.0);
  }
}

TEST_CASE("the work of external forces is what the sheet gains") {
  Scene scene = sheet();
  scene.cloths[0].pins.clear();
  scene.gravity.setZero();
  Simulation sim(scene, step_of(2e-3, "implicit-midpoint"), 1);
  Points forces = Points::Zero(sim.positions().rows(), 3);
  forces.col(0).setConstant(1e-4);
  sim.set_external_forces(forces);
  for (int i = 0; i < 50; ++i) sim.step();
  const StepReport& report = sim.report();
  CHECK(report.energy.kinetic > 0.0);
  CHECK(report.account.loads ==
        Approx(report.energy.kinetic + report.energy.membrane).epsilon(1e-6));
}

TEST_CASE("a floor that carries a sheet along works on it through friction") {
  Scene scene = sheet();
  scene.cloths[0].pins.clear();
  scene.cloths[0].friction = 0.5;
  Obstacle floor;
  floor.mesh = share(floor_square(2.0, 4).moved(Vec3(0, 0, -3e-3)));
  floor.friction = 0.5;
  floor.times = {0.0, 0.4};
  floor.positions = Points::Zero(2, 3);
  floor.positions(1, 0) = 0.4;
  scene.obstacles.push_back(floor);
  Simulation sim(scene, step_of(1e-3), 1);
  while (sim.time() < 0.38) sim.step();
  const StepReport& report = sim.report();
  // The sheet, at first at rest, ends at 1 m/s. Sliding loses as much energy as the sheet gains.
  CHECK(report.energy.kinetic == Approx(0.5 * 0.04 * 0.2).epsilon(0.6));
  CHECK(report.account.scripts == Approx(2.0 * report.energy.kinetic).epsilon(0.1));
  CHECK(report.account.friction == Approx(report.energy.kinetic).epsilon(0.1));
  CHECK(std::abs(report.account.balance) < 1.3);
}

TEST_CASE("an account restarts at zero when the user writes velocities") {
  Simulation sim(sheet(), step_of(2e-3), 1);
  for (int i = 0; i < 20; ++i) sim.step();
  const double lost = sim.report().account.lost;
  CHECK(lost > 0.0);
  Points velocities = sim.velocities();
  velocities.col(2).array() += 5.0;
  sim.set_velocities(velocities);
  sim.step();
  CHECK(sim.report().account.balance < 0.01);
}
