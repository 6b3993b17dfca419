// Tests of the overlap of solid magnets.
#include <random>

#include <catch2/catch.hpp>

#include "core/base/error.h"
#include "core/magnetics/forces/cells.h"
#include "core/magnetics/forces/overlap.h"
#include "core/magnetics/sources/axisymmetric.h"
#include "core/magnetics/sources/polyhedron.h"
#include "core/magnetics/sources/sphere.h"

using namespace loomstone;

namespace {

const Vec3 up(0, 0, 1);

MagneticBody at(SourcePtr source, const Vec3& position, const Vec4& turn = Vec4(1, 0, 0, 0)) {
  return {std::move(source), {position, turn.normalized()}};
}

}  // namespace

TEST_CASE("two cuboids overlap where the distance between their boxes is zero") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const Vec3 size(2.0, 4.0, 0.5);
  const auto cuboid = std::make_shared<Cuboid>(size, up);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x(normal(random), normal(random), normal(random));
    const Vec4 q =
        Vec4(normal(random), normal(random), normal(random), normal(random)).normalized();
    const bool overlaps = overlap(at(cuboid, Vec3::Zero()), at(cuboid, 2.0 * x, q));
    CHECK(overlaps ==
          (box_distance(-0.5 * size, 0.5 * size, -0.5 * size, 0.5 * size, {2.0 * x, q}) == 0.0));
    found += overlaps;
  }
  CHECK(found > 200);
}

TEST_CASE("bodies that touch do not overlap, and slightly closer bodies do") {
  const auto cuboid = std::make_shared<Cuboid>(Vec3(0.02, 0.01, 0.01), up);
  const auto ball = std::make_shared<Sphere>(0.005, up);
  const auto disc = std::make_shared<Cylinder>(0.005, 0.01, up, 0.0);
  for (const SourcePtr& other : {SourcePtr(cuboid), SourcePtr(ball), SourcePtr(disc)}) {
    CHECK_FALSE(overlap(at(cuboid, {3, 2, 1}), at(other, {3, 2, 1.01})));
    CHECK(overlap(at(cuboid, {3, 2, 1}), at(other, {3, 2, 1.0099})));
    CHECK_FALSE(overlap(at(disc, Vec3::Zero()), at(other, {0, 0, 0.01})));
    CHECK(overlap(at(disc, Vec3::Zero()), at(other, {0, 0, 0.0099})));
  }
  CHECK_FALSE(overlap(at(ball, Vec3::Zero()), at(ball, {0.006, 0.008, 0})));
  CHECK(overlap(at(ball, Vec3::Zero()), at(ball, {0.006, 0.0079, 0})));
}

TEST_CASE("a body inside another one overlaps it, but not in the bore of a ring") {
  const auto large = std::make_shared<Cuboid>(Vec3(0.1, 0.1, 0.1), up);
  const auto ring = std::make_shared<Cylinder>(0.05, 0.02, up, 0.03);
  const auto ball = std::make_shared<Sphere>(0.01, up);
  const auto rod = std::make_shared<Cylinder>(0.005, 0.1, up, 0.0);
  for (const SourcePtr& small : {SourcePtr(ball), SourcePtr(rod)}) {
    CHECK(overlap(at(small, {0.01, 0, 0}), at(large, Vec3::Zero())));
    CHECK(overlap(at(large, Vec3::Zero()), at(small, {0.01, 0, 0})));
    CHECK_FALSE(overlap(at(small, {0.01, 0, 0}), at(ring, Vec3::Zero())));
    CHECK(overlap(at(small, {0.04, 0, 0}), at(ring, Vec3::Zero())));
  }
}

TEST_CASE("dipoles and currents fill no space") {
  const auto large = std::make_shared<Cuboid>(Vec3(0.1, 0.1, 0.1), up);
  const auto loop = std::make_shared<Loop>(0.02, 1.0, 1.0);
  const auto dipole =
      std::make_shared<DipoleSet>(Points(Points::Zero(1, 3)), Points(Points::Ones(1, 3)));
  CHECK_FALSE(overlap(at(large, Vec3::Zero()), at(loop, Vec3::Zero())));
  CHECK_FALSE(overlap(at(large, Vec3::Zero()), at(dipole, Vec3::Zero())));
}

TEST_CASE("the message names the first two bodies that overlap") {
  const auto ball = std::make_shared<Sphere>(0.01, up);
  std::vector<MagneticBody> bodies;
  std::vector<std::string> names;
  for (int i = 0; i < 6; ++i) {
    bodies.push_back(at(ball, {0.03 * (i * 5 % 6), 0, 0}));
    names.push_back("body " + std::to_string(i));
  }
  CHECK_NOTHROW(check_no_overlap(bodies, names));
  bodies[4].pose.position = bodies[1].pose.position + Vec3(0, 0.01, 0);
  CHECK_THROWS_WITH(check_no_overlap(bodies, names), Catch::Contains("body 1 overlaps body 4"));
}
