// Tests of contacts between cloth and the body it is attached to.
#include <catch2/catch.hpp>

#include "core/mesh/generators.h"
#include "core/sim/model/build.h"
#include "core/sim/simulation.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// An upright strip whose lower border is attached to a box `gap` [m] below it. The box falls 1 mm
// onto a floor, and the strip collapses onto the box.
Scene strip_on_box(double gap, double stiffness) {
  Scene scene;
  Cloth strip;
  strip.name = "strip";
  const Mat3 upright = Eigen::AngleAxisd(1.55, Vec3::UnitX()).toRotationMatrix();
  strip.mesh = share(grid_cells(0.1, 0.3, 3, 9).moved(Vec3(0, 0, 0.15), upright));
  strip.material.density = 0.3;
  strip.material.weft_stiffness = strip.material.warp_stiffness = stiffness;
  strip.material.shear_stiffness = 0.3 * stiffness;
  scene.cloths.push_back(strip);
  const double lowest = strip.mesh->vertices().col(2).minCoeff();
  RigidBody box_body;
  box_body.name = "box";
  box_body.mesh = share(box(0.1, 0.03, 0.02));
  box_body.shape = BodyShape::Box;
  box_body.density = 300.0;
  box_body.position = Vec3(0, strip.mesh->vertices()(0, 1), lowest - gap - 0.01);
  scene.bodies.push_back(box_body);
  scene.attachments.push_back({"strip", "box", {0, 1, 2, 3}});
  Obstacle floor;
  floor.mesh = share(grid_cells(1.0, 1.0, 1, 1).moved(Vec3(0, 0, lowest - gap - 0.021)));
  scene.obstacles.push_back(floor);
  return scene;
}

// Largest contact distance [m] between the box and features of the strip's attached vertices. If it
// is 0, these features do not collide with the box.
double contact_distance_at_box(double gap) {
  Model model;
  State state;
  build(strip_on_box(gap, 1000.0), model, state);
  double largest = 0.0;
  for (const AttachedVertex& vertex : model.attachments) {
    CHECK(model.collision.attached[vertex.row].surface == 1);
    largest = std::max(largest, model.collision.attached[vertex.row].distance);
  }
  return largest;
}

}  // namespace

TEST_CASE("features of attached vertices have contacts below their distance at the start") {
  // The usual contact distance is 3.8 mm, a tenth of the mean side of triangles.
  CHECK(contact_distance_at_box(6e-3) == Approx(3.8e-3).epsilon(0.02));
  CHECK(contact_distance_at_box(2e-3) == Approx(1.5e-3).epsilon(1e-9));
  CHECK(contact_distance_at_box(5e-4) == Approx(3.75e-4).epsilon(1e-9));
  CHECK(contact_distance_at_box(1e-5) == 0.0);  // closer than contacts need
}

TEST_CASE("of two bodies to which a vertex is attached, that with too close contacts counts") {
  // The usual contact distance is 2.4 mm to the thin box below, and 4.9 mm to the thick box behind.
  // The ratio of the distance at the start to the usual contact distance is smaller for the thick
  // box.
  const auto [below, distance] =
      GENERATE(std::pair(6e-3, 4e-3), std::pair(2.8e-3, 3e-3), std::pair(3.3e-3, 3.4e-3));
  Scene scene = strip_on_box(below, 1000.0);
  scene.bodies[0].thickness = 1e-3;
  RigidBody behind = scene.bodies[0];
  behind.name = "behind";
  behind.thickness = 6e-3;
  behind.position += Vec3(0, -distance - 0.015, below + 0.018);
  scene.bodies.push_back(behind);
  scene.attachments.push_back({"strip", "behind", {0, 1, 2, 3}});
  if (GENERATE(false, true)) {  // in either order
    std::swap(scene.bodies[0], scene.bodies[1]);
    std::swap(scene.attachments[0], scene.attachments[1]);
  }
  const int thick = scene.bodies[0].name == "behind" ? 0 : 1;
  Model model;
  State state;
  build(scene, model, state);
  REQUIRE(model.attachments.size() == 8);
  for (const AttachedVertex& vertex : model.attachments) {
    CHECK(model.collision.attached[vertex.row].surface == 1 + thick);
    CHECK(model.collision.attached[vertex.row].distance == Approx(0.75 * distance).epsilon(1e-6));
  }
}

TEST_CASE("cloth that collapses onto the body it is attached to does not intersect it") {
  const double gap = GENERATE(5e-4, 2e-3, 5e-3), stiffness = GENERATE(300.0, 1e4);
  const bool asynchronous = GENERATE(false, true);
  CAPTURE(gap, stiffness, asynchronous);
  const Scene scene = strip_on_box(gap, stiffness);
  Simulation sim(
      scene,
      asynchronous ? IntegratorOptions(Asynchronous()) : IntegratorOptions(SemiImplicitEuler()), 1);
  std::size_t pairs = 0, close = 0;
  while (sim.time() < 0.8) {
    sim.step();
    for (const auto& pair : sim.intersecting_pairs())
      pairs += pair[0] < scene.cloths[0].mesh->n_triangles();
    close += sim.report().contacts.near > 0;
  }
  CHECK(pairs == 0);
  CHECK(close > 0);
}
