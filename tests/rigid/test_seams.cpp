// Tests of bodies at the border between two obstacles: flush seams, steps and grooves.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/base/rotation.h"
#include "tests/rigid/worlds.h"

using namespace loomstone;

namespace {

RigidObstacle slab(double friction) {
  return {shared(box(1.0, 1.0, 0.2)), friction, Vec3::Zero(), Vec4(1, 0, 0, 0), Points(0, 3)};
}

// Moves a body along x over slabs of 1 m whose upper faces are at z = `heights` [m]. The first slab
// is centred at x = 0. The duration is that of a motion by `way` [m] at the initial velocity.
// Returns the final state.
RigidState slide(const RigidBody& body, const std::vector<double>& heights, double friction,
                 double step, double way) {
  std::vector<RigidObstacle> slabs;
  std::vector<RigidPose> poses;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    poses.push_back({Vec3(static_cast<double>(k), 0, heights[k] - 0.1), Vec4(1, 0, 0, 0)});
    slabs.push_back(slab(friction));
    slabs.back().position = poses.back().position;
  }
  RigidWorld world({body}, slabs, gravity);
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  const int n_steps = static_cast<int>(std::round(way / body.velocity.x() / step));
  for (int i = 0; i < n_steps; ++i) world.advance(step, {none, none}, poses, state);
  return state;
}

RigidBody cube(double speed, double yaw, double friction) {
  RigidBody body = body_of(box(0.1, 0.1, 0.1), "box", Vec3(0, 0.013, 0.05));
  body.friction = friction, body.velocity = Vec3(speed, 0, 0);
  body.orientation = quaternion_from_rotation_vector(Vec3(0, 0, yaw));
  return body;
}

}  // namespace

TEST_CASE("a cube keeps its velocity when it slides over the seams of flush obstacles") {
  const double speed = GENERATE(0.5, 2.0, 5.0, 20.0), yaw = GENERATE(0.0, 0.3, M_PI / 4),
               step = GENERATE(1e-3, 4e-3, 1e-2), higher = GENERATE(0.0, 1e-7, -1e-7);
  CAPTURE(speed, yaw, step, higher);
  const RigidState end = slide(cube(speed, yaw, 0.0), {0.0, higher, 0.0}, 0.0, step, 2.0);
  CHECK(end.positions(0, 0) == Approx(2.0).epsilon(1e-5));
  CHECK(end.velocities(0, 0) == Approx(speed).epsilon(1e-5));
  CHECK(end.velocities.row(0).tail(2).norm() < 1e-3 * speed);
  CHECK(std::abs(end.positions(0, 2) - 0.05) < 2e-6);
}

TEST_CASE("a coin with many sides keeps its velocity on a surface and over its seams") {
  const double speed = GENERATE(0.5, 2.0, 5.0), step = GENERATE(1e-3, 4e-3, 1e-2);
  const int sides = GENERATE(90, 200);
  CAPTURE(speed, step, sides);
  RigidBody coin = body_of(cylinder(0.03, 0.005, sides), "convex", Vec3(0, 0.013, 0.0025));
  coin.friction = 0.0, coin.velocity = Vec3(speed, 0, 0);
  const RigidState end = slide(coin, {0.0, 0.0}, 0.0, step, 1.0);
  CHECK(end.positions(0, 0) == Approx(1.0).epsilon(1e-5));
  CHECK(end.velocities(0, 0) == Approx(speed).epsilon(1e-5));
  CHECK(std::abs(end.positions(0, 2) - 0.0025) < 2e-6);
}

TEST_CASE("friction stops a cube on a row of obstacles as far away as on one") {
  const double step = GENERATE(1e-3, 4e-3, 1e-2), yaw = GENERATE(0.0, 0.3);
  CAPTURE(step, yaw);
  const RigidState end = slide(cube(3.0, yaw, 0.3), {0.0, 0.0, 0.0}, 0.3, step, 6.0);
  // The distance is v^2 / (2 mu g), up to the motion in one step at the initial velocity.
  CHECK(end.positions(0, 0) == Approx(9.0 / (2.0 * 0.3 * 9.81)).margin(3.0 * step));
  CHECK(end.velocities.row(0).norm() < 1e-6);
}

TEST_CASE("a step between two obstacles stops a cube that slides against it") {
  const double step = GENERATE(1e-3, 4e-3, 1e-2), height = GENERATE(1e-3, 0.02, 0.2);
  CAPTURE(step, height);
  const RigidState end = slide(cube(0.5, 0.0, 0.0), {0.0, height}, 0.0, step, 1.0);
  // The cube meets the higher slab when its centre is at 0.45 m, and rests or tips there.
  CHECK(end.positions(0, 0) < 0.451);
  CHECK(std::abs(end.velocities(0, 0)) < 0.25);
}

TEST_CASE("a ball rolls over the seams of flush obstacles without losing speed or hopping") {
  const double speed = GENERATE(0.5, 2.0, 5.0), step = GENERATE(1e-3, 4e-3, 1e-2),
               friction = GENERATE(0.0, 0.5);
  CAPTURE(speed, step, friction);
  RigidBody ball = body_of(icosphere(0.05, 2), "sphere", Vec3(0, 0.013, 0.05));
  ball.friction = friction, ball.velocity = Vec3(speed, 0, 0);
  ball.angular_velocity = Vec3(0, speed / 0.05, 0);
  const RigidState end = slide(ball, {0.0, 0.0, 0.0}, friction, step, 2.0);
  CHECK(end.positions(0, 0) == Approx(2.0).epsilon(1e-4));
  CHECK(end.velocities(0, 0) == Approx(speed).epsilon(1e-4));
  CHECK(std::abs(end.positions(0, 2) - 0.05) < 2e-6);
}

TEST_CASE("a ball that bounces near a seam keeps its velocity along the surface") {
  const double step = GENERATE(5e-4, 1e-3, 4e-3, 1e-2);
  for (int k = 0; k < 21; ++k) {
    const double landing = 0.5 + 0.004 * (k - 10);  // relative to the first slab [m]
    CAPTURE(step, landing);
    RigidBody ball = body_of(icosphere(0.05, 2), "sphere", Vec3(landing - 0.4, 0, 0.25));
    ball.friction = 0.0, ball.restitution = 0.8, ball.velocity = Vec3(2, 0, 0);
    const RigidState end = slide(ball, {0.0, 0.0}, 0.0, step, 0.6);
    CHECK(end.velocities(0, 0) == Approx(2.0).epsilon(1e-4));
  }
}

TEST_CASE("a step between two obstacles stops a ball that rolls against it") {
  const double step = GENERATE(1e-3, 4e-3, 1e-2), height = GENERATE(0.02, 0.05, 0.2);
  CAPTURE(step, height);
  RigidBody ball = body_of(icosphere(0.05, 2), "sphere", Vec3(0, 0, 0.05));
  ball.friction = 0.0, ball.velocity = Vec3(0.5, 0, 0);
  const RigidState end = slide(ball, {0.0, height}, 0.0, step, 1.0);
  // The ball meets a slab that is 2 cm higher when its centre is at 0.5 m - sqrt(5^2 - 3^2) cm.
  CHECK(end.positions(0, 0) < 0.461);
}

TEST_CASE("a ball rests in a groove of two obstacles, and where a floor meets a wall") {
  const double step = GENERATE(1e-4, 1e-3, 1e-2);
  const bool wall = GENERATE(false, true);
  CAPTURE(step, wall);
  const double angle = wall ? 0.0 : -M_PI / 4, r = 0.05;
  const Vec4 turned = quaternion_from_rotation_vector(Vec3(0, angle, 0));
  // Two slabs whose faces are perpendicular to each other and meet in the y axis.
  std::vector<RigidObstacle> slabs = {slab(0.0), slab(0.0)};
  const Mat3 axes = rotation_matrix(turned);
  slabs[0].position = axes * Vec3(0.5, 0, -0.1), slabs[1].position = axes * Vec3(-0.1, 0, 0.5);
  slabs[0].orientation = turned;
  slabs[1].orientation = quaternion_from_rotation_vector(Vec3(0, angle + M_PI / 2, 0));
  std::vector<RigidPose> poses;
  for (const RigidObstacle& each : slabs) poses.push_back({each.position, each.orientation});
  RigidBody ball = body_of(icosphere(r, 2), "sphere", axes * Vec3(r, 0, r));
  ball.friction = 0.0;
  // With a wall, gravity is inclined, so that it also presses the ball against the wall.
  RigidWorld world({ball}, slabs, wall ? Vec3(-5, 0, -8) : gravity);
  RigidState state = world.initial_state();
  const Vec3 start = state.positions.row(0).transpose();
  const Points none = Points::Zero(1, 3);
  for (int i = 0; i < static_cast<int>(0.3 / step); ++i) {
    world.advance(step, {none, none}, poses, state);
    REQUIRE((state.positions.row(0).transpose() - start).norm() < 5e-6);
  }
  CHECK(state.velocities.row(0).norm() < 1e-4);
}
