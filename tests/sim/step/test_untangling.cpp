// Tests of scenes that start with intersections: surfaces come apart and then stay apart.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/mesh/generators.h"
#include "tests/sim/sim_support.h"
#include "tests/support/shaped.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

double bump(double x, double y) {
  const double dx = x - 0.003, dy = y + 0.004;
  return -0.01 + 0.03 * std::exp(-(dx * dx + dy * dy) / 0.0009);
}
double waves(double x, double y) { return 0.006 * std::sin(60.0 * x) * std::cos(50.0 * y) + 0.001; }
double slope(double x, double y) { return 0.4 * (x + y) + 0.05; }

Scene layers(double (*height)(double, double)) {
  Scene scene;
  scene.gravity.setZero();
  scene.allow_initial_intersections = true;
  const TriangleMesh flat = grid_cells(0.2, 0.2, 12, 12);
  for (const char* name : {"flat", "bent"}) {
    Cloth cloth;
    cloth.name = name;
    cloth.mesh = share(name[0] == 'f' ? flat : shaped(flat.moved(Vec3(0.0017, 0.0023, 0)), height));
    scene.cloths.push_back(cloth);
  }
  return scene;
}

// Two sheets of 0.2 m that cross from edge to edge, at random poses with the seed `start`.
Scene crossed(int cells, int start) {
  std::mt19937 random(static_cast<unsigned>(start));
  const auto between = [&](double a, double b) {
    return a + (b - a) * std::generate_canonical<double, 32>(random);
  };
  Scene scene;
  scene.allow_initial_intersections = true;
  const Mat3 tilt = Eigen::AngleAxisd(between(0.0, 0.05), Vec3(1, 2, 3).normalized()).matrix();
  const Mat3 turn = Eigen::AngleAxisd(between(0.6, 2.5), Vec3::UnitY()).matrix();
  const TriangleMesh flat = grid_cells(0.2, 0.2, cells, cells);
  const Vec3 place(between(-0.05, 0.05), between(-0.001, 0.001), between(-0.03, 0.03));
  for (const char* name : {"first", "second"}) {
    Cloth cloth;
    cloth.name = name;
    cloth.material.density = 0.15;
    cloth.mesh = share(name[0] == 'f' ? flat.moved(Vec3::Zero(), tilt) : flat.moved(place, turn));
    scene.cloths.push_back(cloth);
  }
  return scene;
}

// Takes at most `most` steps until nothing intersects. Returns the number of steps, or -1 if
// intersections remain.
int come_apart(Simulation& sim, int most) {
  for (int i = 1; i <= most; ++i) {
    sim.step();
    if (sim.report().contacts.intersections == 0) return i;
  }
  return -1;
}

// Time of the last step that ends with intersections [s], and the largest stretch [1].
struct Parting {
  double time = 0.0, stretch = 1.0;
};

Parting part(Simulation& sim) {
  Parting parting;
  while (sim.time() < 0.6) {
    sim.step();
    if (sim.report().contacts.intersections > 0) parting.time = sim.time();
    parting.stretch = std::max(parting.stretch, sim.report().strain.stretch);
  }
  return parting;
}

}  // namespace

TEST_CASE("layers that start intersecting come apart and stay apart") {
  for (const auto height : {bump, waves, slope})
    for (const char* response : {"implicit", "impulse"}) {
      Scene scene = layers(height);
      scene.response = choice_named<ContactResponse>(response, "response");
      Simulation sim(scene, step_of(4e-3), 1);
      INFO("response " << response << ", pairs at the start " << sim.intersecting_pairs().size());
      REQUIRE(sim.intersecting_pairs().size() > 20);
      // In `slope`, the deepest point is 30 mm, about 16 thicknesses, beyond the other layer. At
      // the target speed of untangling, 100 thicknesses per second, this point needs 40 steps.
      REQUIRE(come_apart(sim, 300) > 0);
      for (int i = 0; i < 25; ++i) {
        sim.step();
        CHECK(sim.report().contacts.intersections == 0);
        REQUIRE(sim.intersecting_pairs().empty());
      }
      CHECK(sim.report().strain.stretch < 1.1);
    }
}

TEST_CASE("cloth that starts inside an obstacle comes out of it") {
  Scene scene;
  scene.allow_initial_intersections = true;
  Cloth cloth;
  cloth.name = "cloth";
  cloth.mesh = share(grid_cells(0.2, 0.2, 12, 12).moved(Vec3(0.001, 0.002, 0.04)));
  scene.cloths.push_back(cloth);
  Obstacle sphere;
  sphere.name = "sphere";
  sphere.mesh = share(icosphere(0.05, 3));
  scene.obstacles.push_back(sphere);
  Simulation sim(scene, step_of(4e-3), 1);
  REQUIRE(come_apart(sim, 100) > 0);
  sim.step();
  double lowest = 1.0;
  for (Index i = 0; i < sim.positions().rows(); ++i)
    lowest = std::min(lowest, sim.positions().row(i).norm());
  CHECK(lowest > 0.049);  // flat faces lie up to 0.23 mm inside the sphere
}

TEST_CASE("untangling ends in the same bits on any number of threads, and after a resume") {
  Simulation one(layers(waves), step_of(4e-3), 1), three(layers(waves), step_of(4e-3), 3),
      resumed(layers(waves), step_of(4e-3), 1);
  for (int i = 0; i < 5; ++i) {
    one.step();
    three.step();
  }
  REQUIRE(one.report().contacts.intersections > 0);
  resumed.restore(one.checkpoint());
  for (int i = 0; i < 40; ++i) {
    one.step();
    three.step();
    resumed.step();
  }
  CHECK(same(one.checkpoint(), three.checkpoint()));
  CHECK(same(one.checkpoint(), resumed.checkpoint()));
}

TEST_CASE("sheets that cross from edge to edge part within half a second") {
  // tests/benchmarks/crossed.py runs ten starts and finer meshes.
  for (const int start : {1, 2, 3, 4}) {
    INFO("start " << start);
    Simulation sim(crossed(15, start), integrator_named("semi-implicit-euler"), 1);
    REQUIRE(sim.intersecting_pairs().size() > 20);
    const Parting parting = part(sim);
    CHECK(parting.time < 0.5);
    CHECK(parting.stretch < 1.2);
  }
}

TEST_CASE("stiff light sheets that cross part as fast as soft ones") {
  for (const int start : {2, 3, 5}) {
    INFO("start " << start);
    Scene scene = crossed(10, start);
    for (Cloth& cloth : scene.cloths) {
      cloth.material.weft_stiffness = cloth.material.warp_stiffness = 1e5;
      cloth.material.shear_stiffness = 5e4;
      cloth.material.density = 0.03;
    }
    Simulation sim(scene, integrator_named("semi-implicit-euler"), 1);
    REQUIRE(sim.intersecting_pairs().size() > 20);
    const Parting parting = part(sim);
    CHECK(parting.time < 0.25);
    CHECK(parting.stretch < 1.2);
  }
}
