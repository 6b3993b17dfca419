#include <catch2/catch.hpp>

#include "core/collision/collision_stage.h"
#include "core/collision/response/impulses.h"
#include "core/collision/tangle/intersections.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;
using Kind = CollisionSurface::Kind;

namespace {

// Free body with the mass and inertia of a solid sphere; `end` is its pose at the end of the
// motion.
struct Ball {
  Points local;
  FreeBodies bodies;

  Ball(TestScene& scene, Index surface, const Vec3& centre, double radius, double mass,
       const RigidPose& end) {
    const CollisionSurface& s = scene.model.surfaces[surface];
    local = scene.x.middleRows(s.first_vertex, s.n_vertices).rowwise() - centre.transpose();
    FreeBody body;
    body.surface = surface;
    body.local = &local;
    body.inverse_mass = 1.0 / mass;
    body.inverse_inertia = Mat3::Identity() / (0.4 * mass * radius * radius);
    body.start.position = centre;
    body.end = end;
    place_body(scene.model, body, body.start, scene.x);
    bodies.push_back(body);
  }
  Ball(const Ball&) = delete;
};

RigidPose pose(const Vec3& position, const Vec3& rotation = Vec3::Zero()) {
  return {position, quaternion_from_rotation_vector(rotation)};
}

}  // namespace

TEST_CASE(
    "an impulse between cloth and a free body keeps linear and angular momentum to rounding") {
  std::mt19937 random(5);
  int n_pressed = 0;
  for (int trial = 0; trial < 50; ++trial) {
    TestScene scene =
        make_scene({{grid_cells(0.1, 0.1, 1, 1), Kind::Cloth, 2e-3, 0.4},
                    {icosphere(0.04, 1).moved(Vec3(0.01, 0.02, 0.05)), Kind::Body, 2e-3, 0.4}});
    const Vec3 centre(0.01, 0.02, 0.05);
    const double mass = 0.03, share = 0.7;
    Ball ball(scene, 1, centre, 0.04, mass,
              pose(centre + Vec3(0.01, 0, -0.03) + random_vector(random, 0.01),
                   random_vector(random, 0.3)));
    Points x1 = shaken(scene.x, 0.01, 100 + trial);
    place_body(scene.model, ball.bodies[0], ball.bodies[0].end, x1);
    const Points given = x1;

    Impulses impulses(scene.model, scene.inverse_mass, ball.bodies);
    ImpulseContact contact;
    // Vertex 4 belongs to the body.
    contact.vertices = {4, scene.model.triangles(0, 0), scene.model.triangles(0, 1),
                        scene.model.triangles(0, 2)};
    contact.weights = {1.0, -0.2, -0.5, -0.3};
    contact.normal = Vec3(0.2, -0.1, 1.0).normalized();
    Vec3 gap = Vec3::Zero();
    for (int i = 0; i < 4; ++i) gap += contact.weights[i] * x1.row(contact.vertices[i]).transpose();
    contact.target = contact.normal.dot(gap) + 5e-3;
    contact.largest_change = 1.0;
    contact.scale = 5e-3;
    contact.friction = 0.4;
    REQUIRE(impulses.prepare(contact, scene.x, x1, share));
    std::vector<ImpulseContact> contacts = {contact};
    impulses.solve(contacts, scene.x, x1, 12, 1e-3);
    n_pressed += contacts[0].pressed > 0.0 && contacts[0].dragged.norm() > 0.0;
    CHECK(contacts[0].dragged.norm() <= 0.4 * contacts[0].pressed * (1 + 1e-12));

    const FreeBody& body = ball.bodies[0];
    const Mat3 inertia = body.inverse_inertia.inverse();
    Vec3 linear = mass * body.moved;
    Vec3 angular = between(body.start, pose(body.end.position - body.moved), share)
                       .position.cross(mass * body.moved) +
                   inertia * body.turned;
    double size = angular.norm();
    for (Index v = 0; v < 4; ++v) {
      // Displacement of a vertex by the impulse, times its mass of 1 g.
      const Vec3 change = (x1.row(v) - given.row(v)).transpose() / 1e3;
      linear += change;
      angular += Vec3((scene.x.row(v) + share * (given.row(v) - scene.x.row(v))).transpose())
                     .cross(change);
    }
    // The tolerance 1e-17 allows for the rounding of coordinates of 0.1 m.
    CHECK(linear.norm() < 1e-14 * (mass * body.moved.norm()) + 1e-17);
    CHECK(angular.norm() <= 1e-12 * size);
  }
  CHECK(n_pressed > 45);
}

TEST_CASE(
    "a ball thrown at a loose sheet transfers momentum, and its final pose agrees with its "
    "vertices") {
  for (const double mass : {1e-4, 0.02, 5.0}) {
    const Vec3 centre(0.003, 0.002, 0.045);
    TestScene scene = make_scene({{grid_cells(0.2, 0.2, 16, 16), Kind::Cloth, 2e-3},
                                  {icosphere(0.04, 2).moved(centre), Kind::Body, 2e-3}});
    for (const double travel : {0.02, 0.3}) {
      Points first;
      for (const int threads : {1, 3}) {
        Ball ball(scene, 1, centre, 0.04, mass,
                  pose(centre - Vec3(0.2 * travel, 0, travel), Vec3(0.3, 0.2, 0.1)));
        Points x1 = shaken(scene.x, 1e-3, 3);
        place_body(scene.model, ball.bodies[0], ball.bodies[0].end, x1);
        const Points given = x1;
        CollisionStage stage(scene.model);
        const CertifyReport report =
            stage.certify(Team{threads}, {scene.x, scene.inverse_mass, {}}, x1, ball.bodies);
        INFO("mass " << mass << " travel " << travel << " withheld " << report.n_withheld());
        CHECK(report.impacts > 0);
        CHECK(report.unresolved == 0);
        CHECK(intersecting_pairs(x1, scene.model.triangles).empty());
        Points placed = x1;
        CHECK_FALSE(place_body(scene.model, ball.bodies[0], ball.bodies[0].end, placed));
        if (threads == 1) first = x1;
        CHECK(x1 == first);
        if (travel < 0.1) {  // impulses alone suffice
          CHECK(report.n_withheld() == 0);
          const Index n = scene.model.surfaces[0].n_vertices;
          const Vec3 sheet = (x1 - given).topRows(n).colwise().sum().transpose() / 1e3;
          const Vec3 change = mass * ball.bodies[0].moved + sheet;
          CHECK(ball.bodies[0].moved.z() > 0.0);
          CHECK(change.norm() < 1e-12 * mass * ball.bodies[0].moved.norm() + 1e-16);
        }
      }
    }
  }
}

TEST_CASE("a body that impulses cannot stop keeps its shape and ends on its path") {
  // The given motion rotates a ball between two prescribed sheets and moves it into or through one
  // of them. Only the ball is free.
  const Vec3 centre(0.003, 0.002, 0.0);
  TestScene scene =
      make_scene({{grid_cells(0.2, 0.2, 8, 8).moved(Vec3(0, 0, 0.042)), Kind::Cloth, 2e-3},
                  {grid_cells(0.2, 0.2, 8, 8).moved(Vec3(0.001, 0.003, -0.042)), Kind::Cloth, 2e-3},
                  {icosphere(0.04, 2).moved(centre), Kind::Body, 2e-3}});
  scene.inverse_mass.setZero();
  for (unsigned seed = 0; seed < 8; ++seed) {
    std::mt19937 random(seed);
    // Most end poses lie far above or below the sheets, and none lies beside them.
    const RigidPose end =
        pose(centre + Vec3(0.1, 0.1, 1.0).cwiseProduct(random_vector(random, 0.3)),
             random_vector(random, 2.0));
    Ball ball(scene, 2, centre, 0.04, 0.1, end);
    Points x1 = scene.x;
    place_body(scene.model, ball.bodies[0], end, x1);
    CollisionStage stage(scene.model);
    const CertifyReport report =
        stage.certify(Team{1}, {scene.x, scene.inverse_mass, {}}, x1, ball.bodies);
    CHECK(report.unresolved == 0);
    CHECK(intersecting_pairs(x1, scene.model.triangles).empty());
    // The ball is faceted, so it can move slightly farther than its clearance of 2 mm.
    CHECK(std::abs(ball.bodies[0].end.position.z()) < 2.4e-3);
    const Index held = scene.model.surfaces[2].first_vertex;
    CHECK(x1.topRows(held) == scene.x.topRows(held));
  }
}

TEST_CASE("a body behind cloth is carried along by an obstacle that pushes through") {
  const Vec3 centre(0.003, 0.002, 0.045);
  for (const double tilt : {0.0, 0.5}) {
    TestScene scene =
        make_scene({{grid_cells(0.2, 0.2, 16, 16), Kind::Cloth, 2e-3},
                    {icosphere(0.04, 2).moved(centre), Kind::Body, 2e-3},
                    {floor_square(0.25, 2).moved(Vec3(0, 0, -0.01)), Kind::Script, 2e-3}});
    Ball ball(scene, 1, centre, 0.04, 0.1, pose(centre));
    const CollisionSurface& plate = scene.model.surfaces[2];
    Points x1 = scene.x;
    const Mat3 turn = Eigen::AngleAxisd(tilt, Vec3::UnitX()).toRotationMatrix();
    for (Index v = plate.first_vertex; v < plate.first_vertex + plate.n_vertices; ++v)
      x1.row(v) = (turn * x1.row(v).transpose() + Vec3(0, 0, 0.3)).transpose();
    const Points given = x1;
    CollisionStage stage(scene.model);
    const CertifyReport report =
        stage.certify(Team{1}, {scene.x, scene.inverse_mass, {}}, x1, ball.bodies);
    CHECK(report.unresolved == 0);
    CHECK(x1.middleRows(plate.first_vertex, plate.n_vertices) ==
          given.middleRows(plate.first_vertex, plate.n_vertices));
    CHECK(ball.bodies[0].end.position.z() > 0.3);
    const auto pairs = intersecting_pairs(x1, scene.model.triangles);
    CHECK(pairs.empty());
  }
}
