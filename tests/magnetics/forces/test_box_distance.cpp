// Tests of distances between oriented boxes.
#include <random>

#include <catch2/catch.hpp>

#include "core/magnetics/forces/cells.h"

using namespace loomstone;

namespace {

const Vec3 half(1.0, 2.0, 3.0);

double distance(const Vec3& position, const Vec4& orientation = Vec4(1, 0, 0, 0)) {
  return box_distance(-half, half, -half, half, {position, orientation});
}

// Computes the distance independently, by alternating projections onto the boxes. The projections
// converge to the closest points of convex bodies.
double by_projections(const RigidPose& pose) {
  const Mat3 r = rotation_matrix(pose.orientation);
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  for (int i = 0; i < 20000; ++i) {
    const Vec3 local = r.transpose() * (a - pose.position);
    b = pose.position + r * local.cwiseMax(-half).cwiseMin(half);
    a = b.cwiseMax(-half).cwiseMin(half);
  }
  return (a - b).norm();
}

}  // namespace

TEST_CASE(
    "boxes face to face, edge to edge and corner to corner have the distance of these features") {
  CHECK(distance({5.0, 0.3, 0.2}) == Approx(3.0));
  CHECK(distance({5.0, 8.0, 0.0}) == Approx(5.0));
  CHECK(distance({4.0, 7.0, 12.0}) == Approx(7.0));
  // Half the angle of a rotation by 45 degrees about z, which turns an edge towards the other box.
  const double turn = 0.125 * 3.14159265358979323846;
  CHECK(distance({6.0, 0.0, 0.0}, {std::cos(turn), 0, 0, std::sin(turn)}) ==
        Approx(5.0 - 3.0 / std::sqrt(2.0)));
}

TEST_CASE("boxes that overlap have no distance") {
  CHECK(distance({0.5, 0.2, 0.1}) == Approx(0.0).margin(1e-6));
  CHECK(distance({0.0, 0.0, 0.0}) == Approx(0.0).margin(1e-6));
  CHECK(distance({1.9, 3.9, 5.9}) == Approx(0.0).margin(1e-6));
}

TEST_CASE("distances of random boxes agree with alternating projections") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 200; ++k) {
    const RigidPose pose{
        Vec3(4.0 * normal(random), 4.0 * normal(random), 4.0 * normal(random)),
        Vec4(normal(random), normal(random), normal(random), normal(random)).normalized()};
    // If faces are nearly parallel, alternating projections converge slowly. The margin allows for
    // the error that remains after the last projection.
    CHECK(distance(pose.position, pose.orientation) == Approx(by_projections(pose)).margin(2e-3));
  }
}
