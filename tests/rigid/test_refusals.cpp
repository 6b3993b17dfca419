// Tests of the input that a rigid world refuses.
#include <catch2/catch.hpp>

#include <limits>

#include "core/base/error.h"
#include "tests/rigid/worlds.h"

using namespace loomstone;
using Catch::Contains;

namespace {

void make(const RigidBody& body) { RigidWorld({body}, {}, Vec3::Zero()); }

RigidBody cube() { return body_of(box(1.0, 1.0, 1.0), "box"); }

}  // namespace

TEST_CASE("bodies without mesh, volume or known shape are refused by name") {
  RigidBody body = cube();
  body.mesh = nullptr;
  CHECK_THROWS_WITH(make(body), Contains("bodies[0].mesh must be a closed mesh"));
  CHECK_THROWS_WITH(make(body_of(floor_square(1.0), "box")),
                    Contains("bodies[0].mesh must be closed"));
  CHECK_THROWS_WITH(make(body_of(box(1, 1, 1), "cylinder")),
                    Contains("bodies[0].shape must be") && Contains("\"cylinder\""));
  CHECK_THROWS_AS(make(body_of(box(1, 1, 1), "cylinder")), InvalidInput);
}

TEST_CASE("a ball is not a box, nor is a turned box") {
  CHECK_THROWS_WITH(make(body_of(icosphere(0.1, 3), "box")), Contains("box within 1 %"));
  const Mat3 turned = Eigen::AngleAxisd(0.1, Vec3::UnitZ()).toRotationMatrix();
  CHECK_THROWS_WITH(make(body_of(box(1, 1, 1).moved(Vec3::Zero(), turned), "box")),
                    Contains("edges along the axes"));
  CHECK_NOTHROW(make(body_of(box(1, 2, 3), "box")));
}

TEST_CASE("a cube is not a sphere, nor is an egg") {
  CHECK_THROWS_WITH(make(body_of(box(1, 1, 1), "sphere")), Contains("sphere within 1 %"));
  Points egg = icosphere(1.0, 3).vertices();
  egg.col(2) *= 1.03;
  CHECK_THROWS_WITH(make(body_of(TriangleMesh(egg, icosphere(1.0, 3).triangles()), "sphere")),
                    Contains("sphere within 1 %"));
  CHECK_NOTHROW(make(body_of(icosphere(1.0, 1), "sphere")));
}

TEST_CASE("parts must exist and have volume") {
  RigidBody body = cube();
  body.shape = BodyShape::Parts;
  CHECK_THROWS_WITH(make(body), Contains("at least one convex mesh"));
  body.parts = {shared(box(1, 1, 1)), nullptr};
  CHECK_THROWS_WITH(make(body), Contains("bodies[0].parts[1] must be a mesh"));
  body.parts = {shared(floor_square(1.0))};
  CHECK_THROWS_WITH(make(body), Contains("bodies[0].parts[0] must have a convex hull with volume"));
}

TEST_CASE("fields outside their limits and quaternions of wrong length are refused") {
  RigidBody body = cube();
  body.density = -1.0;
  CHECK_THROWS_WITH(make(body), Contains("bodies[0].density must be > 0"));
  body = cube();
  body.restitution = 1.5;
  CHECK_THROWS_WITH(make(body), Contains("bodies[0].restitution"));
  body = cube();
  body.orientation = Vec4(1, 1, 0, 0);
  CHECK_THROWS_WITH(make(body), Contains("bodies[0].orientation must be a unit quaternion"));
}

TEST_CASE("obstacles without mesh or with a wrong quaternion are refused") {
  RigidObstacle obstacle = floor_of(1.0, 2);
  obstacle.orientation = Vec4(0, 0, 0, 0);
  CHECK_THROWS_WITH(RigidWorld({}, {obstacle}, Vec3::Zero()), Contains("obstacles[0].orientation"));
  obstacle.mesh = nullptr;
  CHECK_THROWS_WITH(RigidWorld({}, {obstacle}, Vec3::Zero()),
                    Contains("obstacles[0].mesh must be a mesh"));
}

TEST_CASE("states of another scene are refused") {
  RigidWorld one({cube()}, {floor_of(1.0, 2)}, Vec3::Zero()),
      two({cube(), cube()}, {}, Vec3::Zero());
  CHECK_THROWS_WITH(one.restore(two.initial_state()), Contains("one row for each of the 1 bodies"));
  RigidState state = one.initial_state();
  one.save(state);
  RigidState cut = state;
  cut.manifolds.pop_back();
  CHECK_THROWS_WITH(one.restore(cut), Contains("contact points must be those of this scene"));
  cut = state;
  cut.manifolds.push_back(0);
  CHECK_THROWS_WITH(one.restore(cut), Contains("contact points must be those of this scene"));
  RigidWorld bare({cube()}, {}, Vec3::Zero());
  CHECK_THROWS_WITH(bare.restore(state), Contains("contact points must be those of this scene"));
}

TEST_CASE("a wrong number of impulses or poses is refused") {
  RigidWorld world({cube()}, {floor_of(1.0, 2)}, Vec3::Zero());
  RigidState state = world.initial_state();
  const Points one = Points::Zero(1, 3), two = Points::Zero(2, 3);
  CHECK_THROWS_WITH(world.advance(1e-3, {two, one}, {{}}, state),
                    Contains("one row for each of the 1 bodies"));
  CHECK_THROWS_WITH(world.advance(1e-3, {one, one}, {}, state),
                    Contains("one pose for each of the 1 obstacles"));
}

TEST_CASE("a body driven to infinity is a solver failure that names it") {
  RigidWorld world({cube(), body_of(box(1, 1, 1), "box", Vec3(5, 0, 0))}, {}, Vec3::Zero());
  RigidState state = world.initial_state();
  Points impulses = Points::Zero(2, 3);
  impulses(1, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(world.advance(1e-3, {impulses, Points::Zero(2, 3)}, {}, state), SolverFailure);
  world.restore(state = world.initial_state());
  CHECK_THROWS_WITH(world.advance(1e-3, {impulses, Points::Zero(2, 3)}, {}, state),
                    Contains("bodies[1] must stay finite"));
}
