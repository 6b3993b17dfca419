// Tests of whole simulations, such as determinism, resuming, and coupling with rigid bodies.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/collision/model/contact.h"
#include "core/mesh/generators.h"
#include "core/sim/model/state.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

Cloth cloth_of(TriangleMesh mesh, const char* name = "cloth") {
  Cloth cloth;
  cloth.name = name;
  cloth.mesh = share(std::move(mesh));
  return cloth;
}

std::string any_implicit() {
  return GENERATE("semi-implicit-euler", "backward-euler", "implicit-midpoint",
                  "nonlinear-midpoint", "bdf2");
}

Scene drape(Index cells) {
  Scene scene;
  scene.cloths.push_back(cloth_of(grid_cells(0.5, 0.5, cells, cells).moved(Vec3(0, 0, 0.156))));
  Obstacle sphere;
  sphere.name = "sphere";
  sphere.mesh = share(icosphere(0.15, 3).moved(Vec3(0.03, 0.02, 0)));
  scene.obstacles.push_back(sphere);
  return scene;
}

Scene hammock() {
  Scene scene;
  Cloth cloth = cloth_of(grid_cells(0.4, 0.4, 12, 12));
  cloth.pins = {0, 12, 156, 168};
  scene.cloths.push_back(cloth);
  RigidBody box_body;
  box_body.name = "box";
  box_body.mesh = share(box(0.08, 0.08, 0.08));
  box_body.shape = BodyShape::Box;
  box_body.density = 200.0;
  box_body.position = Vec3(0.02, 0.01, 0.06);
  scene.bodies.push_back(box_body);
  return scene;
}

}  // namespace

TEST_CASE("near contacts name the user's vertices and leave the next step as it is") {
  Simulation fallen(drape(24), step_of(4e-3), 1);
  for (int i = 0; i < 20; ++i) fallen.step();
  const Points x = fallen.positions();
  const auto contacts = fallen.near_contacts();
  REQUIRE(!contacts.empty());
  for (const Contact& contact : contacts) {
    CHECK(contact.distance < contact.thickness);
    if (contact.kind != ContactKind::VertexFace || contact.vertices[0] >= x.rows()) continue;
    // The distance to the sphere is at most that to its facets, which lie up to 0.7 mm inside it.
    const Vec3 place = x.row(contact.vertices[0]);
    CHECK((place - Vec3(0.03, 0.02, 0)).norm() - 0.15 < contact.distance + 1e-9);
  }
  Simulation other(drape(24), step_of(4e-3), 1);
  for (int i = 0; i < 20; ++i) other.step();
  fallen.step();
  other.step();
  CHECK(same(fallen.checkpoint(), other.checkpoint()));
}

TEST_CASE("1, 2, 3 and 7 threads give the same bits after a drape with contacts") {
  Simulation one(drape(24), step_of(4e-3), 1);
  for (int i = 0; i < 60; ++i) one.step();
  CHECK(one.report().contacts.near > 20);
  for (const int threads : {2, 3, 7}) {
    Simulation other(drape(24), step_of(4e-3), threads);
    for (int i = 0; i < 60; ++i) other.step();
    CHECK(same(one.checkpoint(), other.checkpoint()));
  }
}

TEST_CASE("stages rebuilt between two steps change no bit") {
  for (const char* method :
       {"semi-implicit-euler", "implicit-midpoint", "bdf2", "backward-euler"}) {
    IntegratorOptions o = step_of(2e-3, method);
    Simulation kept(drape(12), o, 1), rebuilt(drape(12), o, 1);
    for (int i = 0; i < 40; ++i) {
      kept.step();
      rebuilt.step();
      rebuilt.rebuild_stages();
    }
    INFO(method);
    CHECK(same(kept.checkpoint(), rebuilt.checkpoint()));
  }
}

TEST_CASE("a restored checkpoint continues bit for bit, with rigid bodies at their rebuilds") {
  for (const bool bodies : {false, true}) {
    const Scene scene = bodies ? hammock() : drape(16);
    Simulation whole(scene, step_of(2e-3), 1), first(scene, step_of(2e-3), 1),
        second(scene, step_of(2e-3), 1);
    for (int i = 0; i < 120; ++i) whole.step();
    for (int i = 0; i < 80; ++i) first.step();
    second.restore(first.checkpoint());
    CHECK(second.time() == first.time());
    for (int i = 0; i < 40; ++i) second.step();
    CHECK(same(whole.checkpoint(), second.checkpoint()));
  }
}

TEST_CASE("with bodies a checkpoint is possible only at a rebuild, and is refused elsewhere") {
  Simulation sim(hammock(), step_of(2e-3), 1);
  sim.step();
  CHECK_FALSE(sim.may_checkpoint());
  CHECK_THROWS_WITH(sim.checkpoint(), Catch::Contains("rigid_rebuild_interval"));
}

TEST_CASE("a checkpoint of another scene is refused") {
  Simulation a(drape(8), step_of(2e-3), 1), b(drape(9), step_of(2e-3), 1);
  CHECK_THROWS_AS(b.restore(a.checkpoint()), CacheError);
  CHECK_THROWS_WITH(b.restore(a.checkpoint()), Catch::Contains("another scene"));
}

TEST_CASE(
    "a checkpoint of a scene with other motion is refused with the difference, and one of an "
    "earlier version is accepted") {
  const Scene scene = drape(8);
  Simulation sim(scene, step_of(2e-3), 1);
  sim.step();
  Checkpoint kept = sim.checkpoint();
  Scene other = scene;
  other.cloths[0].material.shear_stiffness *= 1.001;
  other.gravity *= 2.0;
  CHECK_THROWS_WITH(Simulation(other, step_of(2e-3), 1).restore(kept),
                    Catch::Contains("differ: scene.cloths, scene.gravity)"));
  CHECK_THROWS_WITH(Simulation(scene, step_of(1e-3), 1).restore(kept),
                    Catch::Contains("differ: integrator.step)"));
  CHECK_THROWS_WITH(Simulation(scene, step_of(2e-3, "bdf2"), 1).restore(kept),
                    Catch::Contains("differ: integrator.method)"));
  other = scene;  // the changes below are as small as rounding errors on another machine
  other.gravity *= 1.0 + 1e-15;
  other.gravity[0] += 1e-17;
  CHECK_NOTHROW(Simulation(other, step_of(2e-3), 1).restore(kept));
  kept.texts.clear();
  CHECK_NOTHROW(Simulation(scene, step_of(2e-3, "bdf2"), 1).restore(kept));
}

TEST_CASE("a step that throws cloth away is reported with the vertex that moved farthest") {
  Simulation sim(drape(8), step_of(2e-3), 1);
  Points force = sim.external_forces();
  force(57, 2) = 1e12;
  sim.set_external_forces(force);
  CHECK_THROWS_WITH(sim.step(), Catch::Contains("cloth vertex 57 moved by"));
}

TEST_CASE("surfaces without a name get a unique one") {
  Scene scene = drape(4);
  Cloth second = scene.cloths[0];
  second.mesh = share(second.mesh->moved(Vec3(0, 0, 0.2)));
  scene.cloths.push_back(second), scene.cloths.push_back(second);
  scene.cloths[2].mesh = share(second.mesh->moved(Vec3(0, 0, 0.2)));
  scene.cloths[0].name = scene.cloths[2].name = "";
  scene.cloths[1].name = "cloth0";
  const Simulation sim(scene, step_of(2e-3), 1);
  CHECK(sim.topology().cloth_names == std::vector<std::string>{"cloth3", "cloth0", "cloth2"});
}

TEST_CASE("explicit methods have no options of a linear solve") {
  for (const char* method : {"explicit-euler", "symplectic-euler"}) {
    const IntegratorOptions o = step_of(1e-4, method);
    CHECK_NOTHROW(Simulation(drape(4), o, 1));
    CHECK(o.implicit() == nullptr);
    CHECK(o.newton() == nullptr);
  }
}

TEST_CASE("a twist rigidity below zero is refused unless it is -1") {
  Scene scene = drape(4);
  scene.cloths[0].material.bending_twist = -0.5;
  CHECK_THROWS_WITH(Simulation(scene, step_of(2e-3), 1),
                    Catch::Contains("material.bending_twist must be >= 0 [N m], or -1 for "
                                    "Huber's, got -0.5"));
  scene.cloths[0].material.bending_twist = -1.0;
  CHECK_NOTHROW(Simulation(scene, step_of(2e-3), 1));
}

TEST_CASE("a hammock catches a falling body, without intersections at the end") {
  Simulation sim(hammock(), step_of(2e-3), 1);
  for (int i = 0; i < 400; ++i) sim.step();
  const double height = sim.body_centres()(0, 2);
  // The body of 0.1 kg makes the cloth sag by centimetres. In free fall, the body would reach -3 m.
  CHECK(height > -0.2);
  CHECK(height < 0.06);
  CHECK(sim.intersecting_pairs().empty());
}

namespace {

// A strip that hangs from five pins, with a body attached to its lower end.
Scene weight_on_strip() {
  Scene scene;
  Cloth strip = cloth_of(
      grid_cells(0.1, 0.4, 4, 16)
          .moved(Vec3::Zero(), Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()).toRotationMatrix()));
  strip.material.density = 0.05;
  strip.pins = {80, 81, 82, 83, 84};
  scene.cloths.push_back(strip);
  RigidBody weight;
  weight.name = "weight";
  weight.mesh = share(box(0.1, 0.02, 0.02));
  weight.shape = BodyShape::Box;
  weight.density = 5000.0;
  weight.position = Vec3(0, 0, -0.22);
  scene.bodies.push_back(weight);
  scene.attachments.push_back({"cloth", "weight", {0, 1, 2, 3, 4}});
  scene.collisions = false;
  return scene;
}

}  // namespace

TEST_CASE("explicit integrators, which have no solve, refuse attachments") {
  Scene scene = weight_on_strip();
  IntegratorOptions o = step_of(1e-5, "symplectic-euler");
  CHECK_THROWS_WITH(Simulation(scene, o, 1),
                    Catch::Contains("implicit or asynchronous integrator"));
}

TEST_CASE("a strip at rest carries the body attached to it, with any integrator") {
  Scene scene = weight_on_strip();
  const std::string method = any_implicit();
  CAPTURE(method);
  const bool damps = method == "semi-implicit-euler" || method == "backward-euler";
  IntegratorOptions o = step_of(damps ? 5e-3 : 2e-3, method);
  scene.cloths[0].material.viscosity_shear = damps ? 0.5 : 8.0;
  Simulation sim(scene, o, 1);
  for (int i = 0; i < (damps ? 1500 : 750); ++i) sim.step();
  CHECK(sim.state().rigid.velocities.norm() < 1e-3);
  // The nominal stress lambda E (lambda^2 - 1)/2, with the stretch lambda and the stiffness E,
  // equals m g / width. The mass m is that of the body and half of the strip; half of the strip has
  // 1/200 of the body's mass.
  const double load = (5000.0 * 0.1 * 0.02 * 0.02 + 0.5 * 0.05 * 0.04) * 9.81 / 0.1;
  double lambda = 1.0;
  for (int k = 0; k < 50; ++k)
    lambda -= (0.5 * 300.0 * lambda * (lambda * lambda - 1) - load) /
              (0.5 * 300.0 * (3 * lambda * lambda - 1));
  // Because Poisson's ratio is 0, the strip does not contract laterally, and the clamps at its ends
  // cause no error. The springs that attach the strip to the body (3e4 N/m per vertex) add 1e-5 m.
  CHECK(0.2 - sim.positions().row(0)(2) == Approx(0.4 * lambda).epsilon(2e-3));
}

TEST_CASE(
    "a moving body shares its momentum with the strip attached to it, and energy does not grow") {
  Scene scene = weight_on_strip();
  const std::string method = any_implicit();
  CAPTURE(method);
  scene.cloths[0].pins.clear();
  scene.gravity = Vec3::Zero();
  scene.bodies[0].velocity = Vec3(0.1, 0.2, -0.3);
  IntegratorOptions o = step_of(1e-3, method);
  o.implicit()->linear_solver = LinearMethod::Direct;
  if (o.newton()) o.newton()->newton_tolerance = 1e-10;
  Simulation sim(scene, o, 1);
  const double body = 5000.0 * 0.1 * 0.02 * 0.02;
  const Vec3 start = body * scene.bodies[0].velocity;
  const double energy = 0.5 * body * scene.bodies[0].velocity.squaredNorm();
  const auto momentum = [&] {  // of the strip; each corner has a third of its triangle's mass
    const Points v = sim.velocities();
    Vec3 sum = Vec3::Zero();
    for (const auto& corner : scene.cloths[0].mesh->triangles().rowwise())
      for (int k = 0; k < 3; ++k) sum += 0.05 * 0.04 / 128 / 3 * v.row(corner[k]).transpose();
    return sum;
  };
  for (int i = 0; i < 150; ++i) {
    sim.step();
    const Vec3 kept = momentum() + body * sim.state().rigid.velocities.row(0).transpose();
    CHECK((kept - start).norm() < 1e-8 * start.norm());  // error of the solves
    const StepReport& r = sim.report();
    // The tolerance allows for the coupling of body and strip, whose error is of first order in the
    // step.
    CHECK(r.energy.kinetic + r.energy.membrane + r.energy.bending + r.energy.body_kinetic <
          1.01 * energy);
  }
}

TEST_CASE("a released strip and the body attached to it fall together with g") {
  Scene scene = weight_on_strip();
  scene.cloths[0].pins.clear();
  IntegratorOptions o = step_of(1e-3);
  o.implicit()->linear_solver = LinearMethod::Direct;
  Simulation sim(scene, o, 1);
  for (int i = 0; i < 100; ++i) sim.step();
  // Cloth and body fall with velocity g t. The tolerance is 1e-6, because attachment springs of
  // 3e4 N/m amplify rounding errors.
  const Points v = sim.velocities();
  for (Index i = 0; i < v.rows(); ++i) CHECK(v(i, 2) == Approx(-9.81 * 0.1).epsilon(1e-6));
  CHECK(sim.body_centres()(0, 2) == Approx(-0.22 - 0.5 * 9.81 * 0.1 * 0.101).epsilon(1e-6));
}

TEST_CASE("frames between steps are interpolated, frames outside the last step refused") {
  Simulation sim(drape(8), step_of(4e-3), 1);
  sim.step();
  const Points before = sim.positions();
  sim.step();
  const Frame middle = sim.frame_at(6e-3);
  CHECK((middle.positions - 0.5 * (before + sim.positions())).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(middle.time == Approx(6e-3));
  CHECK_THROWS_AS(sim.frame_at(1e-3), InvalidInput);
}

TEST_CASE("what Python writes between steps acts: positions, velocities, forces, pins, poses") {
  Scene scene = drape(8);
  scene.cloths[0].pins = {0};
  scene.gravity.setZero();
  Simulation sim(scene, step_of(1e-3), 1);
  const Points start = sim.positions();
  Points forces = Points::Zero(start.rows(), 3), targets = start;
  forces.col(0).setConstant(1e-2);
  sim.set_external_forces(forces);
  targets.row(0) += Eigen::RowVector3d(0, 0, 1e-3);
  sim.set_pin_targets(targets);
  sim.step();
  CHECK(sim.positions().row(0) == targets.row(0));
  CHECK(sim.velocities().col(0).mean() > 1e-3);
  sim.set_obstacle_pose(0, Vec3(0, 0, -0.01), Vec4(1, 0, 0, 0));
  sim.step();
  CHECK(sim.frame().body_vertices(0, 2) ==
        Approx(scene.obstacles[0].mesh->vertices()(0, 2) - 0.01));
  Points bad = start;
  bad(3, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(sim.set_positions(bad), Catch::Contains("row 3"));
  CHECK_THROWS_WITH(sim.set_velocities(Points::Zero(2, 3)), Catch::Contains("81 rows"));
}

TEST_CASE("what cannot be simulated is refused before time passes, naming item and remedy") {
  const auto refused = [](const Scene& scene, const std::string& part) {
    CHECK_THROWS_WITH(Simulation(scene, IntegratorOptions{}, 1), Catch::Contains(part));
  };
  Scene scene = drape(8);
  scene.cloths[0].material.density = -1;
  refused(scene, "cloths[0] (\"cloth\").material.density must be > 0 [kg/m^2], got -1");
  scene = drape(8);
  CHECK_THROWS_WITH(
      Simulation(drape(8), IntegratorOptions{}, 1).set_pin_targets(Points::Zero(81, 3)),
      Catch::Contains("the cloth must have pins to move them"));
  scene.cloths[0].pins = {81};
  refused(scene, "pins must be vertex indices in [0, 80], got 81");
  scene.cloths[0].pins = {4, 4};
  refused(scene, "pins must name each vertex once, got 4 twice");
  CHECK_THROWS_WITH(choice_named<BendingElement>("springs", "cloths[0].bending"),
                    Catch::Contains("mid-edge | hinge"));
  scene = drape(8);
  scene.cloths[0].mesh = share(grid_cells(0.5, 0.5, 8, 8).moved(Vec3(0, 0, 0.05)));
  refused(scene, "lies inside sphere");
  scene = drape(8);
  scene.cloths.push_back(cloth_of(
      grid_cells(0.06, 0.06, 3, 3)
          .moved(Vec3(0.2, 0.2, 0.156), Eigen::AngleAxisd(0.5, Vec3::UnitX()).toRotationMatrix()),
      "other"));
  refused(scene, "intersecting triangle pairs");
  scene.allow_initial_intersections = true;
  CHECK_NOTHROW(Simulation(scene, IntegratorOptions{}, 1));
  scene = drape(8);
  scene.cloths[0].material.bending_coupling = 1.0;
  refused(scene, "bending_coupling");
  scene = drape(8);
  scene.attachments.push_back({"cloth", "none", {0}});
  refused(scene, "attachments[0].body");
  scene = weight_on_strip();
  scene.attachments[0].vertices = {0, 1, 1};
  refused(scene, "attachments[0].vertices must name each vertex once, got 1 twice");
  scene = drape(8);
  scene.obstacles[0].times = {0.0, 1.0};
  refused(scene, "nothing moves");
  scene.obstacles[0].positions = Points::Zero(3, 3);
  refused(scene, "positions must have 2 rows");
  const Scene empty;
  refused(empty, "nothing to simulate");
  IntegratorOptions o;
  o.set_step(0);
  CHECK_THROWS_WITH(Simulation(drape(8), o, 1),
                    Catch::Contains("integrator.step must be > 0 [s], got 0"));
}

TEST_CASE("a step in which the Newton loop finds no solution is taken in halves") {
  Scene scene;
  scene.cloths.push_back(cloth_of(grid_cells(0.4, 0.4, 8, 8)));
  scene.cloths[0].pins = {0, 8};
  scene.collisions = false;
  IntegratorOptions o = step_of(0.02, "backward-euler");
  // Three iterations are too few for whole steps when the cloth is pulled taut, but enough for
  // parts of these steps.
  o.newton()->max_newton_iterations = 3;
  Simulation sim(scene, o, 1);
  std::vector<int> parts;
  for (int i = 0; i < 20; ++i) {
    sim.step();
    parts.push_back(sim.report().parts);
  }
  CHECK(*std::max_element(parts.begin(), parts.end()) > 1);
  // The reference takes steps of 5 ms, which damp the fall less than longer steps. The tolerance is
  // 5 % of the cloth's length.
  IntegratorOptions fine = o;
  fine.set_step(0.005), fine.newton()->max_newton_iterations = 50;
  Simulation judge(scene, fine, 1);
  for (int i = 0; i < 80; ++i) judge.step();
  CHECK((sim.positions() - judge.positions()).rowwise().norm().maxCoeff() < 0.02);
}

TEST_CASE(
    "a cloth dropped on the floor by the Newton loops stays above it, and by backward Euler comes "
    "to rest") {
  for (const char* method : {"backward-euler", "nonlinear-midpoint"}) {
    CAPTURE(method);
    const bool damped = method == std::string("backward-euler");
    const double duration = damped ? 0.6 : 0.3;  // the corners land after 0.06 to 0.11 s
    Scene scene;
    const Eigen::Matrix3d tilt =
        Eigen::AngleAxisd(0.15, Vec3(1, 0.5, 0).normalized()).toRotationMatrix();
    scene.cloths.push_back(cloth_of(grid_cells(0.2, 0.2, 10, 10).moved(Vec3(0, 0, 0.04), tilt)));
    Obstacle floor;
    floor.name = "floor";
    floor.mesh = share(floor_square(1.0));
    scene.obstacles.push_back(floor);
    IntegratorOptions o = step_of(damped ? 4e-3 : 2e-3, method);
    o.implicit()->bending = BendingInStep::Implicit;
    Simulation sim(scene, o, 1);
    const double thickness = 0.002;  // slightly less than the contact distance
    double lowest = 1.0;
    for (int i = 0; i < std::lround(duration / o.step().given.value()); ++i) {
      sim.step();
      lowest = std::min(lowest, sim.positions().col(2).minCoeff());
    }
    CHECK(lowest > 0.0);
    CHECK(sim.report().contacts.near > 20);
    const Vector z = sim.positions().col(2);
    CHECK(z.maxCoeff() < 1.5 * thickness);
    CHECK(z.minCoeff() > 0.25 * thickness);
    CHECK(sim.velocities().rowwise().norm().maxCoeff() < 1e-3);
  }
}

TEST_CASE("a draping cloth never has more energy than at the start") {
  Simulation sim(drape(20), step_of(4e-3), 1);
  const auto energy = [&] {
    const StepReport& r = sim.report();
    return r.energy.kinetic + r.energy.membrane + r.energy.bending + r.energy.gravity;
  };
  sim.step();
  const double start = energy(), g = sim.report().energy.gravity;
  double highest = start, lowest = g;
  for (int i = 0; i < 250; ++i) {
    sim.step();
    highest = std::max(highest, energy());
    lowest = std::min(lowest, sim.report().energy.gravity);
  }
  // Contacts are detected at the start of a step, so their forces can add a little energy within
  // one step. The tolerance is a thousandth of the gravitational energy that the fall releases.
  CHECK(highest - start < 1e-3 * (g - lowest));
}

TEST_CASE("a checkpoint whose numbers are missing is refused") {
  Simulation sim(drape(8), step_of(1e-3, "backward-euler"), 1);
  for (const char* name : {"step", "tangled"}) {
    Checkpoint damaged = sim.checkpoint();
    damaged.integers.at(name).clear();
    CHECK_THROWS_AS(sim.restore(damaged), CacheError);
  }
}

TEST_CASE("a failing step reports where it failed and leaves the last good state") {
  Scene scene = drape(8);
  IntegratorOptions o = step_of(1e-3, "backward-euler");
  o.newton()->newton_tolerance = 1e-30, o.newton()->max_newton_iterations = 2;
  Simulation sim(scene, o, 1);
  const Checkpoint before = sim.checkpoint();
  CHECK_THROWS_WITH(sim.step(), Catch::Contains("step 1 (from time 0 s)") &&
                                    Catch::Contains("backward-euler") &&
                                    Catch::Contains("largest at cloth vertex"));
  CHECK(same(before, sim.checkpoint()));
}

TEST_CASE(
    "a much too long explicit step is reported with its stage and does not reach collision "
    "detection") {
  IntegratorOptions o = step_of(0.05, "explicit-euler");
  Simulation sim(drape(8), o, 1);
  CHECK_THROWS_WITH(
      [&] {
        for (int i = 0; i < 1000; ++i) sim.step();
      }(),
      Catch::Contains("in the stage \"integrate\"") && Catch::Contains("integrator.step"));
  CHECK(sim.positions().allFinite());
}
