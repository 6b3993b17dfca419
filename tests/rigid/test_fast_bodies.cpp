// Tests of bodies that move by more than their thickness, or by a large part of it, in a step. They
// must slide as slow bodies do, and must not pass through other bodies or surfaces.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/base/rotation.h"
#include "tests/rigid/worlds.h"

using namespace loomstone;

namespace {

struct Thing {
  std::string name;
  TriangleMesh mesh;
  std::string shape;
  double height;  // height of the centre when the thing lies on a plane [m]
  double speed;   // [m/s]
};

std::vector<Thing> sliding_things() {
  return {{"coin", cylinder(0.012, 0.002), "convex", 0.001, 1.0},
          {"plate", box(0.2, 0.2, 0.001), "box", 0.0005, 1.0},
          {"card", box(0.085, 0.055, 0.001), "box", 0.0005, 1.0},
          {"small cube", box(0.003, 0.003, 0.003), "box", 0.0015, 3.0},
          {"cube", box(0.01, 0.01, 0.01), "box", 0.005, 10.0},
          {"ball", icosphere(0.001, 3), "sphere", 0.001, 1.0}};
}

RigidBody lying(const Thing& thing, const Vec3& at, double friction) {
  RigidBody body = body_of(thing.mesh, thing.shape, at + Vec3(0, 0, thing.height));
  body.density = 7800.0, body.friction = friction, body.velocity = Vec3(thing.speed, 0, 0);
  return body;
}

// Takes n_steps steps of 1 ms, in which the obstacle does not move.
void run_over(RigidWorld& world, RigidState& state, int n_steps, const RigidObstacle& obstacle) {
  const Points none = Points::Zero(state.positions.rows(), 3);
  const ObstaclePlaces places = obstacle.vertices.rows()
                                    ? ObstaclePlaces({RigidPose{}}, obstacle.vertices)
                                    : ObstaclePlaces({RigidPose{}});
  for (int i = 0; i < n_steps; ++i) world.advance(1e-3, {none, none}, places, state);
}

}  // namespace

TEST_CASE("thin and small bodies keep their velocity when they slide fast without friction") {
  const std::vector<Thing> things = sliding_things();
  const std::size_t k = GENERATE(range(std::size_t{0}, std::size_t{6}));
  const Index cells = GENERATE(1, 60);
  const bool deforms = GENERATE(false, true);
  const Thing& thing = things[k];
  const RigidObstacle flat =
      deforms ? deforming(floor_of(4.0, cells, 0.0)) : floor_of(4.0, cells, 0.0);
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(-0.9, 0.21, 0), Vec3(-0.33, -0.27, 0)}) {
    CAPTURE(thing.name, cells, deforms, at.transpose());
    RigidWorld world({lying(thing, at, 0.0)}, {flat}, gravity);
    RigidState state = world.initial_state();
    const double start = state.positions(0, 0);
    run_over(world, state, 150, flat);
    CHECK(state.positions(0, 0) - start == Approx(0.15 * thing.speed).epsilon(1e-6));
    CHECK(state.velocities(0, 0) == Approx(thing.speed).epsilon(1e-6));
    CHECK(state.velocities.row(0).tail(2).norm() < 1e-6 * thing.speed);
  }
}

TEST_CASE("a cube keeps its velocity when it slides over the edge of a closed obstacle") {
  const double speed = GENERATE(0.5, 2.0, 5.0, 20.0), yaw = GENERATE(0.0, 0.3),
               step = GENERATE(1e-3, 4e-3, 1e-2);
  const bool deforms = GENERATE(false, true);
  CAPTURE(speed, yaw, step, deforms);
  RigidObstacle table = {shared(box(1.0, 1.0, 0.5)), 0.0, Vec3(0, 0, -0.25), Vec4(1, 0, 0, 0),
                         Points(0, 3)};
  if (deforms) {
    table.vertices = table.mesh->vertices();
    table.vertices.col(2).array() -= 0.25;
  }
  RigidBody cube = body_of(box(0.1, 0.1, 0.1), "box", Vec3(0.4, 0.013, 0.05));
  cube.friction = 0.0, cube.velocity = Vec3(speed, 0, 0);
  cube.orientation = quaternion_from_rotation_vector(Vec3(0, 0, yaw));
  RigidWorld world({cube}, {table}, gravity);
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  ObstaclePlaces places({RigidPose{Vec3(0, 0, -0.25), Vec4(1, 0, 0, 0)}});
  if (deforms) places = ObstaclePlaces({RigidPose{Vec3(0, 0, -0.25)}}, table.vertices);
  // Takes steps while the centre of mass is before the edge. Beyond the edge, the cube tips, and
  // the edge pushes the bottom of the cube forward.
  while (state.positions(0, 0) + speed * step < 0.5)
    world.advance(step, {none, none}, places, state);
  CHECK(state.velocities(0, 0) == Approx(speed).epsilon(1e-6));
  CHECK(state.velocities.row(0).tail(2).norm() < 1e-6 * speed);
  while (state.positions(0, 0) < 0.6) world.advance(step, {none, none}, places, state);
  CHECK(state.velocities(0, 0) >= speed * (1.0 - 1e-6));
  CHECK(state.velocities(0, 2) < 1e-6 * speed);
}

TEST_CASE("an obstacle that moves fast takes bodies at rest along") {
  // In a step, the plate moves by up to ten times the size of the body.
  const double speed = GENERATE(5.0, 20.0, 100.0), step = GENERATE(1e-3, 4e-3);
  const std::string shape = GENERATE("sphere", "box", "convex");
  const bool turned = GENERATE(false, true);
  CAPTURE(speed, step, shape, turned);
  RigidObstacle plate = {shared(box(0.01, 0.4, 0.4)), 0.3, Vec3(-0.2, 0, 0), Vec4(1, 0, 0, 0),
                         Points(0, 3)};
  RigidBody body = body_of(
      shape == "box" ? box(0.04, 0.04, 0.04) : icosphere(0.02, shape == "sphere" ? 2 : 1), shape);
  if (turned) body.orientation = quaternion_from_rotation_vector(Vec3(0.3, -1.1, 0.7));
  RigidWorld world({body}, {plate}, Vec3::Zero());
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  double x = -0.2;
  while (x < 0.4) {
    x += speed * step;
    world.advance(step, {none, none}, ObstaclePlaces({RigidPose{Vec3(x, 0, 0)}}), state);
  }
  // If the plate moves by ten times the size of the body in a step, the body may sink into it by a
  // quarter of this size.
  CHECK(state.positions(0, 0) > x + 0.005 + 0.01);
  // A box whose corner is hit turns, so its centre may be slower than the plate.
  CHECK(state.velocities(0, 0) > (turned ? 0.95 : 0.999) * speed);
}

TEST_CASE("an obstacle that moves fast past a body at rest leaves it at rest") {
  const double speed = GENERATE(5.0, 20.0, 100.0), step = GENERATE(1e-3, 4e-3);
  // From each start, the block passes the body at another fraction of a step.
  const double start = GENERATE(-0.3, -0.27, -0.24, -0.21);
  const std::string shape = GENERATE("sphere", "box", "convex");
  CAPTURE(speed, step, start, shape);
  const RigidObstacle block = {shared(box(0.1, 0.1, 0.1)), 0.3, Vec3(start, 0, 0), Vec4(1, 0, 0, 0),
                               Points(0, 3)};
  RigidWorld world({body_of(shape == "box" ? box(0.04, 0.04, 0.04) : icosphere(0.02, 2), shape,
                            Vec3(0, 0.05 + 0.02 + 1e-3, 0))},
                   {block}, Vec3::Zero());
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  for (double x = start; x < 0.4;) {
    x += speed * step;
    world.advance(step, {none, none}, ObstaclePlaces({RigidPose{Vec3(x, 0, 0)}}), state);
  }
  CHECK(state.velocities.norm() == 0.0);
}

TEST_CASE("thin and small bodies keep their velocity when they slide fast on a heavy body") {
  const RigidObstacle ground = floor_of(4.0, 1, 0.0);
  for (const Thing& thing : sliding_things()) {
    CAPTURE(thing.name);
    RigidBody table = body_of(box(1.0, 1.0, 0.1), "box", Vec3(0, 0, 0.05));
    table.density = 1e4, table.friction = 0.0;
    RigidWorld world({table, lying(thing, Vec3(-0.4, 0.21, 0.1), 0.0)}, {ground}, gravity);
    RigidState state = world.initial_state();
    const double start = state.positions(1, 0);
    run(world, state, 1e-3, 70, 1);
    CHECK(state.positions(1, 0) - start == Approx(0.07 * thing.speed).epsilon(1e-3));
    CHECK(state.velocities(1, 0) == Approx(thing.speed).epsilon(1e-3));
    CHECK(std::abs(state.velocities(1, 1)) < 1e-3 * thing.speed);
    CHECK(std::abs(state.velocities(1, 2)) < 2e-2);  // gravity of two steps
  }
}

TEST_CASE("a coin slides as far as friction lets it, wherever it starts") {
  const bool on_table = GENERATE(false, true);
  const Thing coin{"coin", cylinder(0.012, 0.002), "convex", 0.001, 1.0};
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(0.13, 0.21, 0), Vec3(-0.33, 0.27, 0)}) {
    CAPTURE(on_table, at.transpose());
    std::vector<RigidBody> bodies = {lying(coin, at, 0.3)};
    if (on_table) {
      bodies.push_back(body_of(box(2.0, 2.0, 0.1), "box", Vec3(0, 0, -0.05)));
      bodies.back().density = 1e4, bodies.back().friction = 0.3;
    }
    RigidObstacle flat = floor_of(10.0, 1);
    if (on_table) flat.position = Vec3(0, 0, -0.1);
    RigidWorld world(bodies, {flat}, gravity);
    RigidState state = world.initial_state();
    const Points none = Points::Zero(state.positions.rows(), 3);
    for (int i = 0; i < 500; ++i)
      world.advance(1e-3, {none, none}, ObstaclePlaces({{flat.position, flat.orientation}}), state);
    const Vec3 moved = state.positions.row(0).transpose() - at - Vec3(0, 0, 0.001);
    // The distance is v^2 / (2 mu g), up to the motion in one step. Between coin and table, there
    // are up to four contact points, which Bullet collects over several steps. The friction at
    // these points turns the coin and thus deflects it a little.
    CHECK(moved.x() == Approx(1.0 / (2 * 0.3 * 9.81)).margin(1e-3));
    CHECK(std::abs(moved.y()) < (on_table ? 5e-3 : 1e-3));
    CHECK(state.velocities.row(0).norm() < 1e-3);
  }
}

namespace {

// Things that fall or fly at the floor so fast that they could pass through it in one step.
struct Thrown {
  std::string name;
  TriangleMesh mesh;
  std::string shape;
  Vec3 velocity;
  Vec3 turned;  // rotation vector of the orientation [rad]
};

std::vector<Thrown> thrown_things() {
  const TriangleMesh ball = icosphere(0.005, 2), plate = box(0.1, 0.1, 0.001),
                     cube = box(0.005, 0.005, 0.005), coin = cylinder(0.012, 0.002),
                     fine_coin = cylinder(0.012, 0.002, 90);
  const Vec3 down(0, 0, -50), slower(0, 0, -20), level(0, 0, 0);
  return {{"ball", ball, "sphere", down, level},
          {"ball aslant", ball, "sphere", Vec3(30, 10, -40), level},
          {"ball of corners", ball, "convex", down, level},
          {"cube", cube, "box", down, level},
          {"cube aslant", cube, "box", Vec3(30, 10, -40), Vec3(0.3, 0.5, 0.2)},
          {"cube on its tip", cube, "convex", down, Vec3(0.6, -0.6, 0)},
          {"plate", plate, "box", slower, level},
          {"plate aslant", plate, "box", Vec3(10, 0, -20), level},
          {"tilted plate", plate, "box", slower, Vec3(0.2, 0.1, 0)},
          {"steep plate", plate, "convex", slower, Vec3(0.9, 0.1, 0)},
          {"coin", coin, "convex", slower, level},
          {"tilted coin", coin, "convex", slower, Vec3(0.4, 0.1, 0)},
          {"fast coin", coin, "convex", down, Vec3(0.1, 0.3, 0)},
          {"fine coin", fine_coin, "convex", slower, Vec3(0.1, 0.3, 0)}};
}

RigidBody thrown(const Thrown& thing, double way) {
  RigidBody body = body_of(thing.mesh, thing.shape);
  body.velocity = thing.velocity;
  body.orientation = quaternion_from_rotation_vector(thing.turned);
  body.position = Vec3(0.011, 0.023, 0.0) + thing.velocity * (way / thing.velocity.z());
  return body;
}

}  // namespace

TEST_CASE("fast bodies do not pass through a floor") {
  const std::vector<Thrown> things = thrown_things();
  const std::size_t k = GENERATE(range(std::size_t{0}, std::size_t{14}));
  const Index cells = GENERATE(1, 60);
  const bool deforms = GENERATE(false, true);
  const Thrown& thing = things[k];
  const RigidObstacle flat = deforms ? deforming(floor_of(0.6, cells)) : floor_of(0.6, cells);
  for (const double way : {0.0731, 0.0873, 0.1}) {
    CAPTURE(thing.name, cells, deforms, way);
    RigidWorld world({thrown(thing, way)}, {flat}, gravity);
    RigidState state = world.initial_state();
    double lowest = 1.0, fastest = 0.0;
    for (int i = 0; i < 40; ++i) {
      run_over(world, state, 1, flat);
      const bool above = state.positions.row(0).head(2).cwiseAbs().maxCoeff() < 0.29;
      if (above) lowest = std::min(lowest, state.positions(0, 2));
      fastest = std::max(fastest, state.velocities.row(0).norm());
    }
    CHECK(lowest > 0.0);
    CHECK(fastest < thing.velocity.norm() + 1.0);
  }
}

TEST_CASE("fast bodies do not pass through a thin body that lies on the floor") {
  for (const Thrown& thing : thrown_things()) {
    if (thing.velocity.x() != 0.0) continue;  // such bodies would leave the plate
    CAPTURE(thing.name);
    RigidBody plate = body_of(box(0.3, 0.3, 0.001), "box", Vec3(0, 0, 0.0005));
    plate.density = 7800.0;
    RigidWorld world({plate, thrown(thing, 0.0873)}, {floor_of(0.6, 1)}, gravity);
    RigidState state = world.initial_state();
    for (int i = 0; i < 40; ++i) {
      run(world, state, 1e-3, 1, 1);
      CHECK(state.positions.col(2).minCoeff() > 0.0);
    }
    CHECK(state.positions(1, 2) > state.positions(0, 2));
  }
}

TEST_CASE("a body that another one strikes does not pass through the floor below it") {
  // `struck` is at rest 20 mm above the floor. The ball gives it a speed of about 40 mm per step.
  for (const std::string shape : {"sphere", "box", "convex"}) {
    CAPTURE(shape);
    const bool round = shape == "sphere";
    RigidBody struck = body_of(round ? icosphere(0.005, 2) : box(0.01, 0.01, 0.002), shape,
                               Vec3(0.011, 0.023, 0.02));
    RigidBody ball = body_of(icosphere(0.02, 2), "sphere", Vec3(0.011, 0.023, 0.15));
    ball.density = 1e4, ball.velocity = Vec3(0, 0, -40);
    RigidWorld world({struck, ball}, {floor_of(0.6, 7)}, Vec3::Zero());
    RigidState state = world.initial_state();
    double lowest = 1.0;
    for (int i = 0; i < 20; ++i) {
      run(world, state, 1e-3, 1, 1);
      lowest = std::min(lowest, state.positions.col(2).minCoeff());
    }
    CHECK(lowest > 0.0);
  }
}

TEST_CASE("bodies that glide fast past edges and over gaps keep their velocity") {
  for (const Thing& thing : sliding_things()) {
    CAPTURE(thing.name);
    // The thing flies 0.2 mm above a row of posts, and 0.2 mm beside a wall.
    RigidBody body = lying(thing, Vec3(-0.5, 0.0, 0.0002), 0.5);
    const double side = std::abs(thing.mesh.vertices().col(1).minCoeff());
    Points none(0, 3);
    std::vector<RigidObstacle> around;
    for (int i = -10; i <= 30; ++i)
      around.push_back({shared(box(0.02, 0.05, 0.04).moved(Vec3(0.035 * i, 0.0, -0.02))), 0.5,
                        Vec3::Zero(), Vec4(1, 0, 0, 0), none});
    around.push_back({shared(box(1.0, 0.1, 0.1).moved(Vec3(0.1, -side - 0.0502, 0.05))), 0.5,
                      Vec3::Zero(), Vec4(1, 0, 0, 0), none});
    RigidWorld world({body}, around, Vec3::Zero());
    RigidState state = world.initial_state();
    run(world, state, 1e-3, 150, around.size());
    CHECK((state.velocities.row(0).transpose() - body.velocity).norm() < 1e-12 * thing.speed);
  }
}

// The spin about the long axis of a rod has little energy. If contacts turned this spin into a
// tumble of the same angular velocity, its energy would grow by a factor of 7200, the ratio of the
// moments of inertia.
TEST_CASE("a thin rod that falls on a box gains no energy") {
  const double step = GENERATE(5e-4, 1e-3);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  double largest = 0.0;
  for (int trial = 0; trial < 12; ++trial) {
    RigidBody block = body_of(box(0.06, 0.06, 0.06), "box", Vec3(0, 0, 0.03)),
              rod = body_of(box(0.12, 0.001, 0.001), "box", Vec3(0.02 * normal(random), 0, 0.15));
    rod.velocity = Vec3(0, 0, -2);
    rod.orientation =
        Vec4(normal(random), normal(random), normal(random), normal(random)).normalized();
    rod.angular_velocity = 3.0 * Vec3(normal(random), normal(random), normal(random));
    RigidWorld world({block, rod}, {floor_of(4.0, 1)}, gravity);
    RigidState state = world.initial_state();
    const MassProperties& mass = world.mass_properties()[1];
    const auto energy = [&] {
      const Vec3 spin = state.angular_velocities.row(1).transpose();
      return 0.5 * mass.mass * state.velocities.row(1).squaredNorm() +
             0.5 * spin.dot(world_inertia(mass, state.orientations.row(1).transpose()) * spin) +
             mass.mass * 9.81 * state.positions(1, 2);
    };
    const double start = energy();
    for (int i = 0; i < 0.4 / step; ++i) {
      run(world, state, step, 1, 1);
      largest = std::max(largest, energy() / start);
    }
  }
  CHECK(largest < 1.02);
}
