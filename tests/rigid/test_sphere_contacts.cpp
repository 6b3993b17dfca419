// Tests of contacts of spheres. A check for overlap would find the contacts of fast spheres too
// late, so features in the path of a sphere count as contacts before they overlap it.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <random>

#include "core/rigid/contacts/sphere_contacts.h"
#include "tests/rigid/worlds.h"

using namespace loomstone;

namespace {

std::vector<SphereContact> contacts_on(const TriangleMesh& mesh, const Vec3& centre, double radius,
                                       double near, const Vec3& motion = Vec3::Zero()) {
  std::vector<std::array<Vec3, 3>> triangles;
  const Points& x = mesh.vertices();
  for (const auto& t : mesh.triangles().rowwise())
    triangles.push_back(
        {x.row(t[0]).transpose(), x.row(t[1]).transpose(), x.row(t[2]).transpose()});
  std::vector<SphereContact> contacts;
  SphereOnTriangles().find(triangles, {centre, radius, motion}, near, 4, contacts);
  return contacts;
}

RigidBody ball_at(const Vec3& position, const Vec3& velocity, double restitution = 0.0) {
  RigidBody ball = body_of(icosphere(0.005, 3), "sphere", position);
  ball.velocity = velocity, ball.friction = 0.0, ball.restitution = restitution;
  return ball;
}

}  // namespace

TEST_CASE("a plane of triangles is touched once, right below the centre, wherever its edges run") {
  const TriangleMesh plane = floor_square(1.0, 37);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.3, 0.3);
  std::vector<Vec3> centres;
  for (int i = 0; i < 200; ++i) centres.emplace_back(place(random), place(random), 0.049);
  for (const Index v : {400, 700, 801})
    centres.push_back(plane.vertices().row(v).transpose() + Vec3(0, 0, 0.049));
  for (const Vec3& centre : centres) {
    CAPTURE(centre.transpose());
    const auto contacts = contacts_on(plane, centre, 0.05, 0.02);
    REQUIRE(contacts.size() == 1);
    CHECK(contacts[0].gap == Approx(-0.001).margin(1e-15));
    CHECK((contacts[0].normal - Vec3::UnitZ()).norm() < 1e-13);
    CHECK((contacts[0].on_other - Vec3(centre.x(), centre.y(), 0)).norm() < 1e-15);
    CHECK((contacts[0].on_sphere - Vec3(centre.x(), centre.y(), -0.001)).norm() < 1e-15);
  }
}

TEST_CASE(
    "each wall of a corner is touched, an edge and a tip once, and features out of reach are not") {
  const TriangleMesh cube = box(1.0, 1.0, 1.0);
  // Both centres are inside the cube. The first sphere overlaps three faces, and the second sphere
  // overlaps two.
  CHECK(contacts_on(cube, Vec3(0.45, 0.44, 0.43), 0.1, 0.0).size() == 3);
  CHECK(contacts_on(cube, Vec3(0.45, 0.44, 0.0), 0.1, 0.0).size() == 2);
  const auto edge = contacts_on(cube, Vec3(0.53, 0.54, 0.1), 0.06, 0.0);
  REQUIRE(edge.size() == 1);
  CHECK((edge[0].normal - Vec3(0.6, 0.8, 0.0)).norm() < 1e-12);
  CHECK(edge[0].gap == Approx(-0.01).margin(1e-15));
  const auto tip = contacts_on(cube, Vec3(0.52, 0.52, 0.51), 0.03, 1e-12);
  REQUIRE(tip.size() == 1);
  CHECK(tip[0].gap == Approx(0.0).margin(1e-15));
  CHECK(contacts_on(cube, Vec3(0.52, 0.52, 0.51), 0.029, 0.0009).empty());
  CHECK(contacts_on(cube, Vec3(0.52, 0.52, 0.51), 0.029, 0.0011).size() == 1);
  // The centre lies in a face.
  const auto within = contacts_on(cube, Vec3(0.5, 0.1, 0.2), 0.1, 0.0);
  REQUIRE(within.size() == 1);
  CHECK((within[0].normal - Vec3::UnitX()).norm() < 1e-15);
}

TEST_CASE("a feature in the path of a sphere is a contact ahead, in the plane in which they meet") {
  const TriangleMesh cube = box(1.0, 1.0, 1.0);
  const auto face = contacts_on(cube, Vec3(0.1, 0.2, 0.65), 0.1, 1e-3, Vec3(0.2, 0.0, -0.1));
  REQUIRE(face.size() == 1);
  CHECK(face[0].gap == Approx(0.05).epsilon(1e-12));
  CHECK((face[0].normal - Vec3::UnitZ()).norm() < 1e-12);
  const auto both =
      contacts_on(box(2.0, 2.0, 2.0), Vec3(0.85, 0.0, -0.8), 0.1, 1e-3, Vec3(0.2, 0.0, -0.3));
  REQUIRE(both.size() == 2);  // inside the box, the sphere meets the wall first and then the floor
  CHECK((both[0].normal + Vec3::UnitX()).norm() < 1e-12);
  CHECK((both[1].normal - Vec3::UnitZ()).norm() < 1e-12);
  const auto edge = contacts_on(cube, Vec3(0.6, 0.0, 0.8), 0.1, 1e-3, Vec3(-0.04, 0.0, -0.4));
  REQUIRE(edge.size() == 1);
  CHECK(edge[0].normal.x() > 0.5);
  CHECK((edge[0].on_other - Vec3(0.5, 0.0, 0.5)).norm() < 1e-4);
  // The sphere passes the edge at 45 degrees with a gap of 0.04 m.
  CHECK(contacts_on(cube, Vec3(0.4, 0.0, 0.8), 0.1, 1e-3, Vec3(0.4, 0.0, -0.4)).empty());
}

TEST_CASE("balls pass edges and fly through holes as if they were not there") {
  const double radius = 0.005;
  for (const double speed : {2.0, 10.0, 30.0}) {
    for (const double clear : {0.3e-3, 1e-3}) {
      CAPTURE(speed, clear);
      const double s = std::sqrt(0.5);
      const Vec3 nearest = Vec3(0.05, 0, 0.05) + (radius + clear) * Vec3(s, 0, s),
                 velocity = speed * Vec3(s, 0, -s);
      RigidObstacle cube{shared(box(0.1, 0.1, 0.1)), 0.3, Vec3::Zero(), Vec4(1, 0, 0, 0),
                         Points(0, 3)};
      RigidWorld world({ball_at(nearest - 3.7e-3 * velocity, velocity)}, {cube}, Vec3::Zero());
      RigidState state = world.initial_state();
      run(world, state, 1e-3, 12, 1);
      CHECK((state.velocities.row(0).transpose() - velocity).norm() == 0.0);
    }
  }
}

TEST_CASE("a ball that lies on one face of a mesh bounces off another one normally") {
  // The ball is inside the room.
  RigidObstacle room{shared(box(0.2, 0.2, 0.2)), 0.0, Vec3::Zero(), Vec4(1, 0, 0, 0), Points(0, 3)};
  RigidBody ball = body_of(icosphere(0.05, 3), "sphere", Vec3(0, 0.003, -0.05));
  ball.velocity = Vec3(0.4, 0, 0), ball.friction = 0.0, ball.restitution = 1.0;
  RigidWorld world({ball}, {room}, Vec3::Zero());
  RigidState state = world.initial_state();
  run(world, state, 1e-3, 180, 1);
  CHECK(state.velocities(0, 0) == Approx(-0.4).epsilon(1e-6));
}

TEST_CASE("balls that come at 3 m/s, 3 mm in a step, do not enter floors or one another") {
  const double radius = 0.005;
  for (const double angle : {0.0, 0.7, 1.3}) {
    CAPTURE(angle);
    const Vec3 towards(3 * std::sin(angle), 0, -3 * std::cos(angle));
    RigidWorld world({ball_at(Vec3(-0.03, 0.001, 0.0231), towards)}, {floor_of(0.5, 100)},
                     Vec3(0, 0, -9.81));
    RigidState state = world.initial_state();
    for (int i = 0; i < 60; ++i) {
      run(world, state, 1e-3, 1, 1);
      CHECK(state.positions(0, 2) > radius - 1e-6);
    }
    // The ball has no friction and does not catch on the edges between the floor's triangles, so it
    // keeps its velocity along the floor.
    CHECK(state.velocities(0, 0) == Approx(towards.x()).epsilon(1e-9).margin(1e-12));
    CHECK(state.positions(0, 2) < radius + 1e-4);
  }
  RigidWorld world(
      {ball_at(Vec3(-0.02, 0, 0), Vec3(3, 0, 0)), ball_at(Vec3(0.0213, 0.002, 0), Vec3(-1, 0, 0))},
      {}, Vec3::Zero());
  RigidState state = world.initial_state();
  for (int i = 0; i < 30; ++i) {
    run(world, state, 1e-3, 1, 0);
    CHECK((state.positions.row(0) - state.positions.row(1)).norm() > 2 * radius - 1e-6);
  }
  CHECK(state.velocities(0, 0) < 2.0);
  CHECK((state.velocities.row(0) + state.velocities.row(1) - Eigen::RowVector3d(2, 0, 0)).norm() <
        1e-9);
}

TEST_CASE("balls that bounce are thrown back where they touch, no sooner, and keep their energy") {
  // `gap` [m] is the distance between the balls at the start of the step in which they meet.
  for (const double gap : {0.0, 0.03e-3, 0.08e-3, 0.5e-3}) {
    CAPTURE(gap);
    const double x = 0.005 + 0.01 + 0.5 * gap;
    RigidWorld world(
        {ball_at(Vec3(-x, 0, 0), Vec3(1, 0, 0), 1.0), ball_at(Vec3(x, 0, 0), Vec3(-1, 0, 0), 1.0)},
        {}, Vec3::Zero());
    RigidState state = world.initial_state();
    run(world, state, 1e-3, 30, 0);
    CHECK(state.velocities(0, 0) == Approx(-1.0).epsilon(1e-6));
    CHECK(state.velocities(1, 0) == Approx(1.0).epsilon(1e-6));
  }
  RigidWorld world({ball_at(Vec3(0, 0, 0.02503), Vec3(0, 0, -1), 1.0)}, {floor_of(0.5, 40)},
                   Vec3::Zero());
  RigidState state = world.initial_state();
  run(world, state, 1e-3, 40, 1);
  CHECK(state.velocities(0, 2) == Approx(1.0).epsilon(1e-6));
}

TEST_CASE("a ball that passes others closely is not slowed down by them") {
  // The balls pass at a gap of 0.3 mm. If contacts replaced the ball at rest by a tangent plane,
  // the moving ball would be slowed down.
  RigidWorld world(
      {ball_at(Vec3(-0.02, 0.0103, 0), Vec3(2, 0, 0)), ball_at(Vec3::Zero(), Vec3::Zero())}, {},
      Vec3::Zero());
  RigidState state = world.initial_state();
  run(world, state, 1e-3, 20, 0);
  CHECK(state.velocities.row(0) == Eigen::RowVector3d(2, 0, 0));
  CHECK(state.velocities.row(1).norm() == 0.0);
}
