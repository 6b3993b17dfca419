// Tests of steps in which contact forces alone cannot prevent intersections: every step ends free
// of intersections, or reports those that remain.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/mesh/generators.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

RigidBody ball(double radius, double density, const Vec3& position, const Vec3& velocity) {
  RigidBody body;
  body.name = "ball";
  body.mesh = share(icosphere(radius, 2));
  body.shape = BodyShape::Sphere;
  body.density = density;
  body.position = position;
  body.velocity = velocity;
  return body;
}

// Returns the border vertices of a grid of cells x cells cells.
std::vector<Index> border(Index cells) {
  std::vector<Index> vertices;
  for (Index i = 0; i <= cells; ++i)
    for (Index j = 0; j <= cells; ++j)
      if (i == 0 || j == 0 || i == cells || j == cells) vertices.push_back(i * (cells + 1) + j);
  return vertices;
}

Scene drum(double size, Index cells) {
  Scene scene;
  Cloth cloth;
  cloth.name = "cloth";
  cloth.mesh = share(grid_cells(size, size, cells, cells));
  cloth.thickness = 2e-3;
  cloth.pins = border(cells);
  scene.cloths.push_back(cloth);
  return scene;
}

// `layers` loose sheets, the lowest at height `offset` [m], between two plates, which close within
// `duration` [s] to `gap` [m], rest for 0.02 s and open again. If `turning` is true, each plate
// turns by 0.4 rad while it closes. If the gap is negative, the plates pass through each other.
Scene press(double gap, double duration, bool turning = false, double offset = 0.0,
            int layers = 1) {
  Scene scene;
  for (int i = 0; i < layers; ++i) {
    Cloth cloth;
    cloth.name = "cloth " + std::to_string(i);
    cloth.mesh =
        share(grid_cells(0.1, 0.1, 8, 8).moved(Vec3(0.001 * i, 0.002 * i, offset + 4e-3 * i)));
    cloth.thickness = 2e-3;
    scene.cloths.push_back(cloth);
  }
  scene.gravity.setZero();
  for (const double side : {1.0, -1.0}) {
    Obstacle plate;
    plate.name = side > 0 ? "upper" : "lower";
    plate.mesh = share(floor_square(0.3, 2).moved(Vec3(0.001 * side, 0.002, 0)));
    plate.thickness = 2e-3;
    plate.times = {0.0, duration, duration + 0.02, 2 * duration + 0.02};
    plate.positions = Points::Zero(4, 3);
    plate.positions.col(2) << 0.05 * side, 0.5 * gap * side, 0.5 * gap * side, 0.05 * side;
    if (turning) {
      plate.axis_angles = Points::Zero(4, 3);
      plate.axis_angles(0, 2) = 0.4 * side;
    }
    scene.obstacles.push_back(plate);
  }
  return scene;
}

}  // namespace

TEST_CASE("a heavy ball that hits a small drum at a large step is caught without intersection") {
  for (const double speed : {5.0, 30.0}) {
    Scene scene = drum(0.2, 10);
    scene.bodies.push_back(
        ball(0.03, 1000.0, Vec3(0.004, 0.003, 0.05), Vec3(0.2 * speed, 0, -speed)));
    Simulation one(scene, step_of(0.01), 1), three(scene, step_of(0.01), 3);
    double lowest = 1.0;
    for (int i = 0; i < 40; ++i) {
      one.step();
      three.step();
      INFO("speed " << speed << " step " << i << " parts " << one.report().parts << " withheld "
                    << one.report().withheld.vertices);
      REQUIRE(one.report().contacts.unresolved == 0);
      REQUIRE(one.intersecting_pairs().empty());
      lowest = std::min(lowest, one.body_centres()(0, 2));
    }
    CHECK(one.positions() == three.positions());
    CHECK(one.body_centres() == three.body_centres());
    CHECK(lowest < 0.0);                              // the ball reached the cloth
    CHECK(one.body_centres()(0, 2) > lowest + 0.02);  // the cloth threw the ball back
  }
}

TEST_CASE("a light ball squeezed between cloth and floor stays between them") {
  Scene scene = drum(0.2, 10);
  scene.cloths[0].mesh = share(grid_cells(0.2, 0.2, 10, 10).moved(Vec3(0, 0, 0.09)));
  const Index n_pins = static_cast<Index>(scene.cloths[0].pins.size());
  scene.cloths[0].script_times = {0.0, 0.1};
  scene.cloths[0].script_positions.resize(2 * n_pins, 3);
  for (Index i = 0; i < n_pins; ++i)
    for (const Index k : {0, 1}) {
      scene.cloths[0].script_positions.row(k * n_pins + i) =
          scene.cloths[0].mesh->vertices().row(scene.cloths[0].pins[i]);
      if (k == 1) scene.cloths[0].script_positions(n_pins + i, 2) = 0.01;
    }
  Obstacle ground;
  ground.name = "floor";
  ground.mesh = share(floor_square(0.5, 4));
  scene.obstacles.push_back(ground);
  scene.bodies.push_back(ball(0.03, 20.0, Vec3(0.004, 0.003, 0.0301), Vec3::Zero()));
  Simulation sim(scene, step_of(5e-3), 1);
  for (int i = 0; i < 60; ++i) {
    sim.step();
    INFO("step " << i << " parts " << sim.report().parts << " height " << sim.body_centres()(0, 2));
    REQUIRE(sim.report().contacts.unresolved == 0);
    for (const auto& pair : sim.intersecting_pairs())
      REQUIRE(pair[0] >= 200);  // only the ball and the floor may intersect
    // The floor bears the load. The ball may overlap the floor by up to 0.2 mm.
    CHECK(sim.body_centres()(0, 2) > 0.0298);
    CHECK(sim.body_centres()(0, 2) < 0.0302);
  }
}

TEST_CASE(
    "plates that leave the cloth room never make it intersect, at any gap and with or without "
    "rotation") {
  for (const bool turning : {false, true})
    // Only the first gap exceeds the contact distance.
    for (const double gap : {3e-3, 0.6e-3, 1e-4, 5e-5}) {
      Simulation sim(press(gap, 0.02, turning, 0.02), step_of(0.01), 1);
      for (int i = 0; i < 8; ++i) {
        sim.step();
        INFO("turning " << turning << " gap " << gap << " step " << i << " parts "
                        << sim.report().parts);
        REQUIRE(sim.report().contacts.unresolved == 0);
        for (const auto& pair : sim.intersecting_pairs()) REQUIRE(pair[0] >= 128);
        REQUIRE(sim.positions().allFinite());
      }
    }
}

TEST_CASE(
    "cloth that plates run through is forced to intersect them, never other cloth, and the report "
    "says so") {
  std::int64_t intersections = 0;
  for (const int layers : {1, 2, 4}) {
    const bool turning = layers != 2;
    Simulation sim(press(-4e-3, 0.02, turning, -2e-3 * (layers - 1), layers), step_of(0.01), 1);
    const Index n_cloth = 128 * layers;
    std::int64_t unresolved = 0;
    for (int i = 0; i < 8; ++i) {
      sim.step();
      unresolved += sim.report().contacts.unresolved;
      intersections += sim.report().contacts.intersections;
      CHECK(sim.report().parts <= 64);
      CHECK(sim.positions().allFinite());
      CHECK(sim.velocities().allFinite());
      // Intersections are never hidden: the report counts them.
      std::int64_t pairs = 0;
      for (const auto& pair : sim.intersecting_pairs()) {
        pairs += pair[0] < n_cloth;
        CHECK(pair[1] >= n_cloth);
      }
      CHECK(pairs == sim.report().contacts.intersections);
      CHECK(pairs == sim.report().contacts.forced);
      CHECK(pairs == static_cast<std::int64_t>(sim.forced_pairs().size()));
      const std::vector<std::uint8_t> marks = sim.frame().contact;
      for (const auto& pair : sim.forced_pairs())
        for (int k = 0; k < 3; ++k) CHECK(marks[sim.topology().triangles(pair[0], k)] == 2);
    }
    CHECK(unresolved > 0);
  }
  CHECK(intersections > 0);
}

TEST_CASE(
    "a step that fails at its full length is taken in parts, with the same bits on any team and "
    "after resuming") {
  for (const bool body : {false, true}) {
    const char* method = body ? "semi-implicit-euler" : "bdf2";
    Scene scene = press(1e-4, 0.02, true, 0.02);
    scene.gravity = Vec3(0, 0, -9.81);
    if (body) {
      // The ball falls from above. In the fourth step, it meets the upper plate, which has opened
      // again.
      scene.bodies.push_back(ball(0.02, 500.0, Vec3(0.12, 0.1, 0.1), Vec3(0.1, 0.2, 0)));
      scene.rigid_rebuild_interval = 2;
    }
    Simulation one(scene, step_of(0.02, method), 1), three(scene, step_of(0.02, method), 3);
    int parts = 1;
    for (int i = 0; i < 2; ++i) {
      one.step();
      three.step();
      parts = std::max(parts, one.report().parts);
      CHECK(one.report().contacts.unresolved == 0);
    }
    INFO(method << " body " << body);
    CHECK(parts > 1);
    CHECK(one.time() == 0.04);
    CHECK(same(one.checkpoint(), three.checkpoint()));
    Simulation resumed(scene, step_of(0.02, method), 1);
    resumed.restore(one.checkpoint());
    for (int i = 0; i < 2; ++i) {
      one.step();
      resumed.step();
    }
    CHECK(same(one.checkpoint(), resumed.checkpoint()));
  }
}

TEST_CASE("poses and pins that the user has set are reached through the parts of a step") {
  Scene scene = press(1e-4, 0.02);
  scene.cloths[0].mesh = share(grid_cells(0.1, 0.1, 8, 8).moved(Vec3(0, 0, 0.02)));
  scene.cloths[0].pins = {0};
  for (Obstacle& plate : scene.obstacles) {
    plate.mesh =
        share(floor_square(0.3, 2).moved(Vec3(0.002, 0.001, plate.name == "upper" ? 0.05 : -0.05)));
    plate.times.clear();
    plate.positions.resize(0, 3);
  }
  Simulation sim(scene, step_of(0.02), 1);
  // In one step, the plates turn by 0.4 rad in opposite directions and approach each other to a gap
  // of 0.1 mm. The pinned corner moves down to the middle of this gap.
  Points targets = sim.positions();
  targets(0, 2) = 0.0;
  sim.set_pin_targets(targets);
  sim.set_obstacle_pose(0, Vec3(0, 0, -0.05 + 5e-5), Vec4(std::cos(0.2), 0, 0, std::sin(0.2)));
  sim.set_obstacle_pose(1, Vec3(0, 0, 0.05 - 5e-5), Vec4(std::cos(0.2), 0, 0, -std::sin(0.2)));
  sim.step();
  CHECK(sim.report().parts > 1);
  CHECK(sim.report().contacts.unresolved == 0);
  for (const auto& pair : sim.intersecting_pairs()) CHECK(pair[0] >= 128);
  CHECK(sim.positions().row(0) == targets.row(0));
  const Points bodies = sim.frame().body_vertices, local = scene.obstacles[0].mesh->vertices();
  const Mat3 turn = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
  for (Index i = 0; i < local.rows(); ++i)
    CHECK((bodies.row(i).transpose() - (turn * local.row(i).transpose() + Vec3(0, 0, -0.05 + 5e-5)))
              .norm() < 1e-15);
}

TEST_CASE(
    "explicit integrators keep the thickness as gap, with cloth, obstacle and free body, and "
    "resume bit for bit") {
  Scene scene = drum(0.2, 8);
  scene.cloths[0].mesh = share(grid_cells(0.2, 0.2, 8, 8).moved(Vec3(0, 0, 0.05)));
  scene.cloths[0].pins = {0, 8, 72, 80};
  Cloth lower = scene.cloths[0];
  lower.name = "lower";
  lower.pins.clear();
  lower.mesh = share(grid_cells(0.1, 0.1, 5, 5).moved(Vec3(0.003, 0.002, 2.1e-3)));
  scene.cloths.push_back(lower);
  Obstacle ground;
  ground.name = "floor";
  ground.mesh = share(floor_square(0.6, 6));
  ground.thickness = 2e-3;
  scene.obstacles.push_back(ground);
  scene.bodies.push_back(ball(0.02, 50.0, Vec3(0.004, 0.003, 0.08), Vec3(0, 0, -0.5)));
  scene.bodies[0].thickness = 2e-3;
  scene.rigid_rebuild_interval = 100;
  Simulation sim(scene, step_of(2e-4, "symplectic-euler"), 1),
      resumed(scene, step_of(2e-4, "symplectic-euler"), 3);
  double lowest = 1.0;
  for (int i = 0; i < 800; ++i) {
    sim.step();
    if (i == 599) resumed.restore(sim.checkpoint());
    if (i >= 600) resumed.step();
    lowest = std::min(lowest, sim.positions().bottomRows(36).col(2).minCoeff());
    REQUIRE(sim.report().contacts.unresolved == 0);
  }
  CHECK(same(sim.checkpoint(), resumed.checkpoint()));
  CHECK(sim.intersecting_pairs().empty());
  CHECK(lowest > 0.99 * 2e-3);  // the free sheet rests one contact distance above the floor
  CHECK(sim.positions().bottomRows(36).col(2).maxCoeff() < 2.2e-3);
  // The sheet that hangs from its corners has caught the ball half-way to the floor.
  CHECK(sim.body_centres()(0, 2) > 0.04);
}

TEST_CASE("a strip twisted fast by its ends stays free of intersection and tears nothing") {
  // Each end turns by 11 degrees per step.
  const Index cells = 24, across = 8;
  Scene scene;
  Cloth strip;
  strip.name = "strip";
  strip.mesh = share(grid_cells(0.3, 0.1, cells, across));
  strip.thickness = 1.2e-3;
  const Points& x = strip.mesh->vertices();
  for (Index v = 0; v < x.rows(); ++v)
    if (std::abs(x(v, 0) - x.col(0).minCoeff()) < 1e-9 ||
        std::abs(x(v, 0) - x.col(0).maxCoeff()) < 1e-9)
      strip.pins.push_back(v);
  const Index n_pins = static_cast<Index>(strip.pins.size());
  const double middle = x.col(0).mean(), duration = 0.42;
  strip.script_positions.resize(200 * n_pins, 3);
  for (Index k = 0; k < 200; ++k) {
    strip.script_times.push_back(duration * static_cast<double>(k) / 199.0);
    for (Index i = 0; i < n_pins; ++i) {
      const Vec3 at = x.row(strip.pins[i]).transpose(), centre(at.x(), x.col(1).mean(), 0.0);
      const double angle =
          (at.x() < middle ? 1.0 : -1.0) * 2.0 * M_PI * 6.0 * strip.script_times.back();
      strip.script_positions.row(k * n_pins + i) =
          (centre + Eigen::AngleAxisd(angle, Vec3::UnitX()) * (at - centre)).transpose();
    }
  }
  scene.cloths.push_back(strip);
  scene.gravity.setZero();
  Simulation sim(scene, step_of(5e-3), 1);
  for (int i = 0; i < 84; ++i) {
    sim.step();
    INFO("step " << i + 1 << " parts " << sim.report().parts << " withheld "
                 << sim.report().withheld.vertices);
    REQUIRE(sim.report().contacts.unresolved == 0);
    REQUIRE(sim.intersecting_pairs().empty());
  }
  CHECK(sim.report().strain.stretch < 2.0);  // measured 1.61
}
