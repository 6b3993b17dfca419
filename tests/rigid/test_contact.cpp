// Tests of bodies in contact: rest, friction, restitution, and surfaces that move.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/base/rotation.h"
#include "tests/rigid/worlds.h"

using namespace loomstone;

namespace {

// Height [m] of the lowest vertex of the body's mesh above z = 0.
double clearance(const RigidWorld& world, const RigidState& state, Index body,
                 const TriangleMesh& mesh) {
  return world_vertices(state, body, mesh, world.mass_properties()[body]).col(2).minCoeff();
}

// Distance [m] that a box with friction mu slides down an incline of `slope` [rad] in `seconds`.
double slide(double slope, double mu, double seconds, const std::string& shape) {
  RigidObstacle incline = floor_of(4.0, 8, mu);
  RigidBody brick = body_of(box(0.2, 0.2, 0.1), shape, Vec3(0.03, 0.02, 0.05));
  brick.friction = mu;
  // The floor is horizontal; gravity is rotated instead.
  RigidWorld world({brick}, {incline}, Vec3(9.81 * std::sin(slope), 0, -9.81 * std::cos(slope)));
  RigidState state = world.initial_state();
  const Vec3 start = state.positions.row(0).transpose();
  run(world, state, 1e-3, static_cast<int>(std::lround(seconds / 1e-3)), 1);
  return state.positions(0, 0) - start.x();
}

}  // namespace

TEST_CASE("a resting body stays and sinks in by less than a tenth of a millimetre") {
  for (const std::string shape : {"box", "convex", "sphere", "parts"}) {
    CAPTURE(shape);
    RigidBody body = body_of(shape == "sphere" ? icosphere(0.1, 3) : box(0.2, 0.3, 0.2), shape,
                             Vec3(0.01, 0.02, 0.1));
    if (shape == "parts") {
      body.parts = {shared(box(0.1, 0.3, 0.2).moved(Vec3(-0.05, 0, 0))),
                    shared(box(0.1, 0.3, 0.2).moved(Vec3(0.05, 0, 0)))};
    }
    RigidWorld world({body}, {floor_of(2.0, 4)}, gravity);
    RigidState state = world.initial_state();
    const Points start = state.positions;
    run(world, state, 1e-3, 1000, 1);
    CHECK(clearance(world, state, 0, *body.mesh) > -1e-4);
    CHECK((state.positions - start).norm() < 1e-4);
    CHECK(state.velocities.norm() < 1e-3);
    CHECK(rotation_vector(state.orientations.row(0).transpose()).norm() < 1e-3);
  }
}

TEST_CASE(
    "a body counts as supported if contacts connect it to an obstacle, not if bodies meet in the "
    "air") {
  std::vector<RigidBody> cubes;
  for (const Vec3& at : {Vec3(0, 0, 0.05), Vec3(0, 0, 0.15), Vec3(0.5, 0, 0.06), Vec3(0.5, 0, 1.0),
                         Vec3(0.5, 0, 1.1)})
    cubes.push_back(body_of(box(0.1, 0.1, 0.1), "box", at));
  cubes[3].velocity = Vec3(0, 0, 0.1), cubes[4].velocity = Vec3(0, 0, -0.1);  // these two collide
  RigidWorld world(cubes, {floor_of(2.0, 4)}, gravity);
  RigidState state = world.initial_state();
  CHECK(world.supported() == std::vector<std::uint8_t>{0, 0, 0, 0, 0});
  CHECK(world.touching() == std::vector<std::uint8_t>{0, 0, 0, 0, 0});
  run(world, state, 1e-3, 1, 1);
  CHECK(world.touching() == std::vector<std::uint8_t>{1, 1, 0, 0, 0});
  run(world, state, 1e-3, 9, 1);  // the third cube has fallen 0.5 mm, to 9.5 mm above the floor
  // The fifth cube has slowed the fourth.
  CHECK(state.velocities(3, 2) < state.velocities(2, 2) + 0.05);
  CHECK(world.supported() == std::vector<std::uint8_t>{1, 1, 0, 0, 0});
  run(world, state, 1e-3, 60, 1);
  CHECK(world.supported() == std::vector<std::uint8_t>{1, 1, 1, 0, 0});
}

TEST_CASE("a dropped body comes to rest on the floor at its own height") {
  for (const std::string shape : {"box", "convex"}) {
    CAPTURE(shape);
    const TriangleMesh brick = box(0.1, 0.06, 0.04);
    RigidWorld world({body_of(brick, shape, Vec3(0, 0, 0.1))}, {floor_of(2.0, 4)}, gravity);
    RigidState state = world.initial_state();
    run(world, state, 1e-3, 1500, 1);
    CHECK(state.positions(0, 2) == Approx(0.02).margin(1e-4));
    CHECK(clearance(world, state, 0, brick) > -1e-4);
    CHECK(state.velocities.norm() < 1e-3);
  }
}

namespace {

// Returns a crate of 0.3 x 0.2 x 0.2 m, open at the top, with walls of 10 mm. Its centre of mass
// lies below the middle of its bounding box.
TriangleMesh open_crate() {
  Points vertices(16, 3);
  for (int k = 0; k < 8; ++k) {
    const Vec3 signs(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    vertices.row(k) = signs.cwiseProduct(Vec3(0.15, 0.1, 0.1)).transpose();
    vertices.row(8 + k) = signs.cwiseProduct(Vec3(0.14, 0.09, k & 4 ? 0.1 : 0.09)).transpose();
  }
  // Quadrilaterals, counter-clockwise as seen from outside of the material.
  const int sides[14][4] = {{0, 2, 3, 1},     {0, 1, 5, 4},    {1, 3, 7, 5},   {3, 2, 6, 7},
                            {2, 0, 4, 6},     {8, 9, 11, 10},  {8, 12, 13, 9}, {9, 13, 15, 11},
                            {11, 15, 14, 10}, {10, 14, 12, 8}, {4, 5, 13, 12}, {5, 7, 15, 13},
                            {7, 6, 14, 15},   {6, 4, 12, 14}};
  Triangles triangles(28, 3);
  for (int s = 0; s < 14; ++s) {
    triangles.row(2 * s) << sides[s][0], sides[s][1], sides[s][2];
    triangles.row(2 * s + 1) << sides[s][0], sides[s][2], sides[s][3];
  }
  return TriangleMesh(vertices, triangles);
}

}  // namespace

TEST_CASE("an open crate as a box rests on its bottom") {
  RigidWorld world({body_of(open_crate(), "box", Vec3(0, 0, 0.2))}, {floor_of(1.0, 1)}, gravity);
  RigidState state = world.initial_state();
  const MassProperties mass = world.mass_properties().front();
  CHECK(mass.centre.z() < -0.01);
  run(world, state, 1e-3, 1000, 1);
  CHECK(std::abs(state.positions(0, 2) - (0.1 + mass.centre.z())) < 1e-4);
}

TEST_CASE("cubes of one centimetre stay at rest in a stack at steps of a millisecond") {
  for (const std::string shape : {"box", "convex"}) {
    CAPTURE(shape);
    std::vector<RigidBody> cubes;
    for (int k = 0; k < 5; ++k)
      cubes.push_back(body_of(box(0.01, 0.01, 0.01), shape, Vec3(0, 0, 0.005 + 0.01 * k)));
    RigidWorld world(cubes, {floor_of(1.0, 3)}, gravity);
    RigidState state = world.initial_state();
    const Points start = state.positions;
    run(world, state, 1e-3, 2000, 1);
    CHECK((state.positions - start).rowwise().norm().maxCoeff() < 1e-4);
    CHECK(state.velocities.rowwise().norm().maxCoeff() < 1e-3);
  }
}

TEST_CASE("more sweeps of the solver make a stack more stable") {
  double moved[2];
  for (const int k : {0, 1}) {
    std::vector<RigidBody> cubes;
    for (int i = 0; i < 5; ++i)
      cubes.push_back(body_of(box(0.01, 0.01, 0.01), "box", Vec3(0, 0, 0.005 + 0.01 * i)));
    RigidWorld world(cubes, {floor_of(1.0, 3)}, gravity, true, k == 0 ? 3 : 50);
    RigidState state = world.initial_state();
    const Points start = state.positions;
    run(world, state, 1e-3, 500, 1);
    moved[k] = (state.positions - start).rowwise().norm().maxCoeff();
  }
  CHECK(moved[1] < 0.3 * moved[0]);
}

TEST_CASE("a brick sticks on an incline below the friction angle and slides above it") {
  const double mu = 0.4, angle = std::atan(mu);
  for (const std::string shape : {"box", "convex"}) {
    CAPTURE(shape);
    CHECK(std::abs(slide(0.9 * angle, mu, 1.0, shape)) < 1e-3);
    const double slope = 1.25 * angle, seconds = 0.5;
    const double acceleration = 9.81 * (std::sin(slope) - mu * std::cos(slope));
    // The tolerance of 5 % covers effects of the first contact and of edges of the floor's mesh.
    CHECK(slide(slope, mu, seconds, shape) ==
          Approx(0.5 * acceleration * seconds * seconds).epsilon(0.05));
  }
}

TEST_CASE("friction of a pair is the geometric mean") {
  RigidBody brick = body_of(box(0.2, 0.2, 0.1), "box", Vec3(0, 0, 0.05));
  brick.friction = 0.9;
  brick.velocity = Vec3(1.0, 0, 0);
  RigidWorld world({brick}, {floor_of(4.0, 8, 0.1)}, gravity);
  RigidState state = world.initial_state();
  run(world, state, 1e-3, 200, 1);
  CHECK(state.velocities(0, 0) == Approx(1.0 - 0.3 * 9.81 * 0.2).epsilon(0.02));
}

TEST_CASE("a bouncing ball returns with its restitution times the speed") {
  for (double restitution : {0.0, 0.5, 0.9}) {
    CAPTURE(restitution);
    RigidBody ball = body_of(icosphere(0.05, 3), "sphere", Vec3(0, 0, 0.1));
    ball.velocity = Vec3(0, 0, -2.0);
    ball.restitution = restitution;
    RigidWorld world({ball}, {floor_of(1.0, 2)}, Vec3::Zero());
    RigidState state = world.initial_state();
    run(world, state, 1e-3, 60, 1);
    CHECK(state.velocities(0, 2) == Approx(2.0 * restitution).margin(1e-9));
  }
}

TEST_CASE("two colliding balls keep their momentum") {
  RigidBody ball = body_of(icosphere(0.05, 3), "sphere", Vec3(-0.2, 0.01, 0.0));
  ball.velocity = Vec3(1.0, 0, 0);
  RigidBody heavy = body_of(icosphere(0.05, 3), "sphere");
  heavy.density = 4000.0;
  RigidWorld world({ball, heavy}, {}, Vec3::Zero());
  RigidState state = world.initial_state();
  const double light_mass = world.mass_properties()[0].mass,
               heavy_mass = world.mass_properties()[1].mass;
  run(world, state, 1e-3, 300, 0);
  const Vec3 momentum = light_mass * state.velocities.row(0).transpose() +
                        heavy_mass * state.velocities.row(1).transpose();
  CHECK((momentum - light_mass * ball.velocity).norm() < 1e-13);
  CHECK(state.velocities(1, 0) > 0.1);
}

TEST_CASE("a moving floor carries a brick and a rising one lifts it without a gap") {
  RigidBody brick = body_of(box(0.1, 0.1, 0.1), "box", Vec3(0, 0, 0.05));
  brick.friction = 1.0;
  const bool deforms = GENERATE(false, true);
  CAPTURE(deforms);
  const RigidObstacle flat = floor_of(1.0, 2, 1.0);
  RigidWorld world({brick}, {deforms ? deforming(flat) : flat}, gravity);
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  const double h = 1e-3;
  for (int i = 1; i <= 1000; ++i) {
    // The floor accelerates along x at 1 m/s^2 (less than mu g) and rises at 0.1 m/s.
    const double t = i * h;
    const Vec3 moved(0.5 * t * t, 0, 0.1 * t);
    ObstaclePlaces places({{moved, Vec4(1, 0, 0, 0)}});
    if (deforms)
      places = ObstaclePlaces({RigidPose{}}, flat.mesh->vertices().rowwise() + moved.transpose());
    world.advance(h, {none, none}, places, state);
  }
  CHECK(state.positions(0, 0) == Approx(0.5).margin(2e-3));
  CHECK(state.positions(0, 2) == Approx(0.15).margin(1e-4));
  CHECK(state.velocities(0, 0) == Approx(1.0).epsilon(0.01));
}

TEST_CASE("a rotating floor carries a brick round") {
  RigidBody brick = body_of(box(0.1, 0.1, 0.05), "box", Vec3(0.2, 0, 0.025));
  brick.friction = 1.0;
  const double omega = 1.0;  // omega^2 r = 0.2 m/s^2, far below mu g
  brick.velocity = Vec3(0, 0.2 * omega, 0);
  brick.angular_velocity = Vec3(0, 0, omega);
  RigidWorld world({brick}, {floor_of(1.0, 2, 1.0)}, gravity);
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  for (int i = 1; i <= 1000; ++i) {
    const double t = i * 1e-3;
    world.advance(
        1e-3, {none, none},
        ObstaclePlaces({{Vec3::Zero(), quaternion_from_rotation_vector(Vec3(0, 0, omega * t))}}),
        state);
  }
  CHECK((state.positions.row(0).transpose() - Vec3(0.2 * std::cos(1.0), 0.2 * std::sin(1.0), 0.025))
            .norm() < 2e-3);
  CHECK(rotation_vector(state.orientations.row(0).transpose()).z() == Approx(1.0).margin(0.01));
}

TEST_CASE("a rising surface throws a ball up at the speed of the point of contact") {
  // The plane z = c t^2 (x + 1/2) rotates about an edge and stretches. Below the ball it
  // rises at a speed of c t.
  const RigidObstacle flat = floor_of(1.0, 4);
  RigidBody ball = body_of(icosphere(0.05, 3), "sphere", Vec3(0, 0, 0.05));
  RigidWorld world({ball}, {deforming(flat)}, gravity);
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  const double h = 1e-3, c = 4.0, end = 0.25;
  double carried = 0.0;
  for (int i = 1; i <= 400; ++i) {
    const double t = std::min(i * h, end);
    Points x = flat.mesh->vertices();
    x.col(2) = (x.col(0).array() + 0.5) * c * t * t;
    world.advance(h, {none, none}, ObstaclePlaces({RigidPose{}}, x), state);
    if (i * h <= end) carried = state.velocities(0, 2);
  }
  // At the end of its motion, the surface at x = 0 rises at c t = 1 m/s. The tolerance allows for a
  // slide of the ball towards the edge that does not move, where the surface is slower. The ball
  // then flies freely for 0.15 s.
  CHECK(carried == Approx(1.0).epsilon(0.15));
  CHECK(state.velocities(0, 2) == Approx(carried - 9.81 * 0.15).margin(0.02));
}

TEST_CASE("a fast small ball does not pass through a thin floor") {
  RigidBody ball = body_of(icosphere(0.005, 2), "sphere", Vec3(0.01, 0.02, 0.5));
  ball.velocity = Vec3(0, 0, -50.0);  // ten radii per step
  RigidWorld world({ball}, {floor_of(1.0, 2)}, gravity);
  RigidState state = world.initial_state();
  run(world, state, 1e-3, 200, 1);
  CHECK(state.positions(0, 2) > 0.0);
}

// Distance [m] that a disc slides until it rests. The disc starts at 1 m/s and spins at `spin`
// [rad/s]. Its rim carries its weight, and friction there opposes the local sliding velocity.
double way_of_rim(double radius, double spin, double friction, double gravity) {
  constexpr int n_points = 64;
  const double step = 1e-5;
  double velocity = 1.0, way = 0.0;
  while (velocity > 1e-3) {
    double force = 0.0, torque = 0.0;  // per mass, and per mass and radius
    for (int k = 0; k < n_points; ++k) {
      const double angle = 2.0 * M_PI * (k + 0.5) / n_points;
      const double x = velocity - spin * radius * std::sin(angle),
                   y = spin * radius * std::cos(angle), speed = std::hypot(x, y);
      force -= x / speed / n_points;
      torque += (x * std::sin(angle) - y * std::cos(angle)) / speed / n_points;
    }
    velocity += step * friction * gravity * force;
    spin = std::max(0.0, spin + step * friction * gravity * torque * 2.0 / radius);
    way += step * velocity;
  }
  return way;
}

TEST_CASE("friction of a disc that slides and spins opposes the sliding of each contact") {
  const double spin = GENERATE(0.0, 20.0, 40.0, 80.0), step = GENERATE(2e-4, 1e-3);
  CAPTURE(spin, step);
  RigidBody disc = body_of(cylinder(0.05, 0.01, 64), "convex", Vec3(0, 0, 0.005));
  disc.friction = 0.3, disc.velocity = Vec3(1, 0, 0), disc.angular_velocity = Vec3(0, 0, spin);
  RigidWorld world({disc}, {floor_of(4.0, 1)}, gravity);
  RigidState state = world.initial_state();
  run(world, state, step, static_cast<int>(1.2 / step), 1);
  CHECK(state.velocities.row(0).norm() < 1e-6);
  // The tolerance is needed because each step has only four contacts at the rim, and their places
  // relative to the velocity change.
  CHECK(state.positions(0, 0) == Approx(way_of_rim(0.05, spin, 0.3, 9.81)).epsilon(0.01));
}

TEST_CASE("a cylinder loses the speed of the impacts of its facets while it rolls, and no more") {
  const int sides = GENERATE(64, 128, 200, 250);
  const double step = GENERATE(2e-4, 1e-3, 4e-3), radius = 0.05, speed = 0.25;
  CAPTURE(sides, step);
  RigidBody roller = body_of(cylinder(radius, 2.0 * radius, sides), "convex", Vec3(0, 0, radius));
  roller.orientation = Vec4(std::sqrt(0.5), std::sqrt(0.5), 0, 0);
  roller.friction = 0.5, roller.velocity = Vec3(speed, 0, 0);
  roller.angular_velocity = Vec3(0, speed / radius, 0);
  RigidWorld world({roller}, {floor_of(4.0, 1, 0.5)}, gravity);
  RigidState state = world.initial_state();
  run(world, state, step, static_cast<int>(std::round(1.0 / step)), 1);
  // Each facet, of length 2 r sin(pi / n), lands without a bounce. The angular momentum about the
  // edge that lands stays the same, so the angular velocity falls by the fraction
  // 2/3 (1 - cos(2 pi / n)).
  const double share = 2.0 / 3.0 * (1.0 - std::cos(2.0 * M_PI / sides)),
               rate = share / (2.0 * radius * std::sin(M_PI / sides));
  const double wanted = speed / (1.0 + rate * speed);
  // Facets bounce a little within Bullet's tolerance of a micrometre, so the loss is accurate only
  // to a few hundredths of the speed.
  CHECK(state.velocities(0, 0) == Approx(wanted).epsilon(0.07));
  if (sides == 64) CHECK(speed - state.velocities(0, 0) > 0.6 * (speed - wanted));
}
