// Tests of obstacles that squeeze a body, or a row of bodies, from opposite sides, as the jaws of a
// gripper do.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/rigid/worlds.h"

using namespace loomstone;

namespace {

constexpr double side = 0.05, lift = 0.3;                                       // [m]
constexpr double lift_time = 0.3;                                               // [s]
constexpr double closed_at = 0.2, lifted_at = 0.6, opened_at = 0.8, end = 1.4;  // [s]

// Two jaws close on bodies with the total width `width` [m], lift them, and open again. When the
// jaws are closed, the distance between them is shorter than `width` by `squeeze` [m].
struct Gripper {
  double width, squeeze;

  std::vector<RigidPose> at(double time) const {
    const double apart = 0.2 * side;
    double gap = width + apart;
    if (time < closed_at)
      gap = std::lerp(width + apart, width - squeeze, time / closed_at);
    else if (time < lifted_at)
      gap = width - squeeze;
    else if (time < opened_at)
      gap = std::lerp(width - squeeze, width + apart, (time - lifted_at) / (opened_at - lifted_at));
    const double height = 0.5 * side + lift * std::clamp((time - closed_at) / lift_time, 0.0, 1.0);
    const double place = 0.5 * (gap + side);
    return {RigidPose{},
            {Vec3(place, 0, height), Vec4(1, 0, 0, 0)},
            {Vec3(-place, 0, height), Vec4(1, 0, 0, 0)}};
  }
};

// Returns a floor and the two jaws before they close.
std::vector<RigidObstacle> floor_and_jaws(const Gripper& gripper, double friction) {
  std::vector<RigidObstacle> obstacles{floor_of(1.0, 1)};
  for (const int jaw : {1, 2})
    obstacles.push_back({shared(box(side, side, side)), friction, gripper.at(0.0)[jaw].position,
                         Vec4(1, 0, 0, 0), Points(0, 3)});
  return obstacles;
}

struct Lifted {
  // Height above the start and distance from the z axis just before the jaws open again, and height
  // above the start at the end [m].
  double height, wander, left;
};

Lifted lift_body(RigidBody body, double squeeze, double friction, double step) {
  const Gripper gripper{side, squeeze};
  body.position = Vec3(1e-4 * side, 0, 0.5 * side), body.friction = friction;
  RigidWorld world({body}, floor_and_jaws(gripper, friction), gravity);
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  Lifted result{};
  for (int i = 1; i * step < end; ++i) {
    const std::vector<RigidPose> poses = gripper.at(i * step);
    world.advance(step, {none, none}, poses, state);
    if (i * step < lifted_at) {
      result.height = state.positions(0, 2) - 0.5 * side;
      result.wander = state.positions.row(0).head<2>().norm();
    }
  }
  result.left = state.positions(0, 2) - 0.5 * side;
  return result;
}

}  // namespace

TEST_CASE("jaws that overlap a body hold it, lift it and let it fall") {
  const double squeeze = GENERATE(1e-3, 5e-3, 0.02, 0.1) * side, step = GENERATE(1e-3, 4e-3, 1e-2);
  const std::string shape = GENERATE("box", "convex", "cylinder", "sphere");
  CAPTURE(squeeze, step, shape);
  const RigidBody body = shape == "cylinder" ? body_of(cylinder(0.5 * side, side), "convex")
                         : shape == "sphere" ? body_of(icosphere(0.5 * side, 3), "sphere")
                                             : body_of(box(side, side, side), shape);
  const Lifted lifted = lift_body(body, squeeze, 0.8, step);
  // The tolerance is 1 % of the lift.
  CHECK(std::abs(lifted.height - lift) < 0.01 * lift);
  CHECK(lifted.wander < 0.01 * lift);
  CHECK(std::abs(lifted.left) < 0.01 * lift);  // it lies on the floor again
}

TEST_CASE("jaws hold a row of bodies") {
  const double step = GENERATE(1e-3, 4e-3, 1e-2), squeeze = GENERATE(1e-3, 0.02) * side;
  CAPTURE(step, squeeze);
  constexpr int n = 3;
  const Gripper gripper{n * side, squeeze};
  std::vector<RigidBody> bodies;
  for (int i = 0; i < n; ++i) {
    bodies.push_back(
        body_of(box(side, side, side), "box", Vec3((i - 0.5 * (n - 1)) * side, 0, 0.5 * side)));
    bodies.back().friction = 0.8;
  }
  RigidWorld world(bodies, floor_and_jaws(gripper, 0.8), gravity);
  RigidState state = world.initial_state();
  const Points none = Points::Zero(n, 3);
  for (int i = 1; i * step < lifted_at; ++i)
    world.advance(step, {none, none}, gripper.at(i * step), state);
  for (int i = 0; i < n; ++i)
    CHECK(std::abs(state.positions(i, 2) - 0.5 * side - lift) < 0.01 * lift);
}

TEST_CASE("a bar that touches the floor and the ceiling with its ends falls flat") {
  constexpr double length = 0.4, thickness = 0.04;
  const double height = GENERATE(0.05, 0.0402);
  CAPTURE(height);
  RigidBody bar = body_of(box(length, thickness, thickness), "box", Vec3(0, 0, 0.5 * height));
  // At this angle, the bar overlaps the floor and the ceiling by 50 micrometres.
  const double angle = (height + 1e-4 - thickness) / length;
  bar.orientation = quaternion_from_rotation_vector(Vec3(0, angle, 0));
  RigidObstacle ceiling{shared(box(1.0, 1.0, 0.1)), 0.3, Vec3(0, 0, height + 0.05),
                        Vec4(1, 0, 0, 0), Points(0, 3)};
  RigidWorld world({bar}, {floor_of(1.0, 1), ceiling}, gravity);
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  const std::vector<RigidPose> poses{RigidPose{}, {ceiling.position, ceiling.orientation}};
  for (int i = 0; i < 500; ++i) world.advance(1e-3, {none, none}, poses, state);
  CHECK(std::abs(state.positions(0, 2) - 0.5 * thickness) < 1e-3 * thickness);
}

TEST_CASE("bodies between walls that leave room are moved apart") {
  const RigidObstacle wall{shared(box(side, side, side)), 0.3, Vec3::Zero(), Vec4(1, 0, 0, 0),
                           Points(0, 3)};
  const double overlap = 5e-5, gap = 4e-4;
  // From left to right: a wall, an overlap, a box, an overlap, a box, a gap, a wall.
  const double first = side - overlap, second = 2 * (side - overlap), last = second + side + gap;
  std::vector<RigidBody> bodies{body_of(box(side, side, side), "box", Vec3(first, 0, 0.5 * side)),
                                body_of(box(side, side, side), "box", Vec3(second, 0, 0.5 * side))};
  const std::vector<RigidPose> poses{RigidPose{},
                                     {Vec3(0, 0, 0.5 * side), Vec4(1, 0, 0, 0)},
                                     {Vec3(last, 0, 0.5 * side), Vec4(1, 0, 0, 0)}};
  std::vector<RigidObstacle> obstacles{floor_of(1.0, 1), wall, wall};
  for (std::size_t i = 1; i < 3; ++i) obstacles[i].position = poses[i].position;
  RigidWorld world(bodies, obstacles, gravity);
  RigidState state = world.initial_state();
  const Points none = Points::Zero(2, 3);
  for (int i = 0; i < 200; ++i) world.advance(1e-3, {none, none}, poses, state);
  // The tolerance allows for the tenth of an overlap that is left after corrections.
  CHECK(state.positions(0, 0) > side - 0.1 * overlap);
  CHECK(state.positions(1, 0) - state.positions(0, 0) > side - 0.1 * overlap);
  CHECK(state.positions(1, 0) < last - side + 0.1 * overlap);
}

TEST_CASE("jaws without friction do not hold a body") {
  const Lifted lifted = lift_body(body_of(box(side, side, side), "box"), 0.01 * side, 0.0, 1e-3);
  CHECK(lifted.height < 0.01 * lift);
}
