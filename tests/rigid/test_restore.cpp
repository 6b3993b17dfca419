// Tests of worlds restored from a state.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>

#include "core/base/rotation.h"
#include "tests/rigid/worlds.h"

using namespace loomstone;

namespace {

constexpr double step = 1e-3;

bool same_bits(const RigidState& a, const RigidState& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(double)) == 0;
  };
  return same(a.positions, b.positions) && same(a.orientations, b.orientations) &&
         same(a.velocities, b.velocities) && same(a.angular_velocities, b.angular_velocities) &&
         a.manifolds == b.manifolds;
}

// A stack of five boxes, spheres thrown at it, a body with two parts, a capsule (as a hull), and a
// floor that sways and turns.
struct Pile {
  std::vector<RigidBody> bodies;
  std::vector<RigidObstacle> obstacles{floor_of(2.0, 4, 0.5)};

  Pile() {
    for (int k = 0; k < 5; ++k)
      bodies.push_back(
          body_of(box(0.1, 0.1, 0.1), k % 2 ? "box" : "convex", Vec3(0, 0, 0.05 + 0.1 * k)));
    for (int k = 0; k < 3; ++k) {
      bodies.push_back(body_of(icosphere(0.04, 2), "sphere", Vec3(-0.4 - 0.1 * k, 0.01 * k, 0.2)));
      bodies.back().velocity = Vec3(3.0, 0, 1.0);
    }
    RigidBody twin = body_of(box(0.2, 0.05, 0.05), "parts", Vec3(0.03, 0.02, 0.6));
    twin.parts = {shared(box(0.1, 0.05, 0.05).moved(Vec3(-0.05, 0, 0))),
                  shared(box(0.1, 0.05, 0.05).moved(Vec3(0.05, 0, 0)))};
    bodies.push_back(twin);
    bodies.push_back(body_of(capsule(0.03, 0.1, 12), "convex", Vec3(0.2, 0.05, 0.3)));
  }
  RigidWorld world() const { return {bodies, obstacles, Vec3(0, 0, -9.81)}; }

  void advance(RigidWorld& world, RigidState& state, int i) const {
    const Points none = Points::Zero(state.positions.rows(), 3);
    const double t = (i + 1) * step;
    const RigidPose pose{Vec3(0.02 * std::sin(8.0 * t), 0, 0),
                         quaternion_from_rotation_vector(Vec3(0, 0, 0.1 * t))};
    world.advance(step, {none, none}, ObstaclePlaces({pose}), state);
  }
  // Takes the steps from `first` to `last` - 1, and rebuilds the world every 40 steps. `state` must
  // be the initial state or contain the contact manifolds. At the end, it contains the manifolds.
  void run(RigidWorld& world, RigidState& state, int first, int last) const {
    for (int i = first; i < last; ++i) {
      if (i % 40 == 0) {
        if (i > first) world.save(state);
        world.restore(state);
      }
      advance(world, state, i);
    }
    world.save(state);
  }
};

}  // namespace

TEST_CASE("a world restored at a rebuild continues bit for bit like an uninterrupted one") {
  const Pile pile;
  for (int stop : {40, 160, 400}) {
    CAPTURE(stop);
    RigidWorld live = pile.world();
    RigidState through = live.initial_state();
    pile.run(live, through, 0, stop);
    const RigidState saved = through;
    pile.run(live, through, stop, stop + 500);

    RigidWorld resumed = pile.world();
    RigidState state = saved;
    pile.run(resumed, state, stop, stop + 500);
    CHECK(same_bits(state, through));
    CHECK(state.manifolds.size() > 1000);  // there are contacts to restore
  }
}

TEST_CASE("a world can be reset to an earlier state") {
  const Pile pile;
  RigidWorld world = pile.world();
  RigidState state = world.initial_state();
  pile.run(world, state, 0, 200);
  const RigidState saved = state;
  pile.run(world, state, 200, 300);
  RigidState again = saved;
  pile.run(world, again, 200, 300);
  CHECK(same_bits(state, again));
}

TEST_CASE("restoring and saving at once keeps the state") {
  const Pile pile;
  RigidWorld world = pile.world();
  RigidState state = world.initial_state();
  pile.run(world, state, 0, 120);
  RigidState copy = state;
  world.restore(copy);
  world.save(copy);
  CHECK((copy.positions - state.positions).norm() == 0.0);
  // The copy can lack contact manifolds of pairs whose bounding boxes separated in the last step,
  // and have additional ones of pairs whose boxes met, so the two sizes agree only roughly.
  CHECK(copy.manifolds.size() > 0.8 * state.manifolds.size());
  CHECK(copy.manifolds.size() < 1.2 * state.manifolds.size());
}

TEST_CASE("rebuilding often does not disturb a stack") {
  std::vector<RigidBody> cubes;
  for (int k = 0; k < 5; ++k)
    cubes.push_back(body_of(box(0.01, 0.01, 0.01), "box", Vec3(0, 0, 0.005 + 0.01 * k)));
  RigidWorld world(cubes, {floor_of(1.0, 3)}, Vec3(0, 0, -9.81));
  RigidState state = world.initial_state();
  const Points start = state.positions;
  for (int i = 0; i < 200; ++i) {
    run(world, state, step, 5, 1);
    world.save(state);
    world.restore(state);
  }
  CHECK((state.positions - start).rowwise().norm().maxCoeff() < 1e-4);
}

TEST_CASE("a restored world knows where its obstacles were") {
  // The floor rises at 1 m/s. If its position were lost, the next step would throw the brick.
  const bool deforms = GENERATE(false, true);
  CAPTURE(deforms);
  const RigidObstacle flat = floor_of(1.0, 2);
  RigidWorld world({body_of(box(0.1, 0.1, 0.1), "box", Vec3(0, 0, 0.05))},
                   {deforms ? deforming(flat) : flat}, Vec3(0, 0, -9.81));
  RigidState state = world.initial_state();
  const Points none = Points::Zero(1, 3);
  for (int i = 1; i <= 200; ++i) {
    const Vec3 moved(0, 0, i * step);
    ObstaclePlaces places({{moved, Vec4(1, 0, 0, 0)}});
    if (deforms)
      places = ObstaclePlaces({RigidPose{}}, flat.mesh->vertices().rowwise() + moved.transpose());
    world.advance(step, {none, none}, places, state);
    if (i % 20 == 0) {
      world.save(state);
      world.restore(state);
    }
  }
  CHECK(state.velocities(0, 2) == Approx(1.0).epsilon(0.01));
  CHECK(state.positions(0, 2) == Approx(0.25).margin(1e-3));
}
