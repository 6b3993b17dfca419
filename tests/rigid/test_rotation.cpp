// Tests of rotation vectors, quaternions and rotation matrices.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/base/rotation.h"

using namespace loomstone;

namespace {

const Vec3 vectors[] = {{0.3, -1.1, 0.7}, {1e-3, 2e-3, -1e-3}, {1e-9, 0, 1e-9},
                        {0, 0, 3.1},      {1e-5, 1e-4, 0},     {0, 0, 0}};

}  // namespace

TEST_CASE("rotation vector, quaternion and matrix represent the same rotation") {
  for (const Vec3& v : vectors) {
    const Vec4 q = quaternion_from_rotation_vector(v);
    CHECK(q.norm() == Approx(1.0).epsilon(1e-15));
    // The tolerance allows for the rounding of cos and sin.
    CHECK((rotation_vector(q) - v).norm() <= 1e-15 + 4e-16 * v.norm());
    const Mat3 expected = v.norm() > 0
                              ? Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix()
                              : Mat3(Mat3::Identity());
    CHECK((rotation_matrix(q) - expected).norm() < 1e-15 * 10);
    CHECK((quaternion_from_matrix(rotation_matrix(q)) - q).norm() < 1e-15 * 10);
  }
}

TEST_CASE("small rotations keep their relative accuracy") {
  for (double angle = 1e-1; angle > 1e-12; angle /= 10.0) {
    const Vec3 v(0.0, angle, 0.0);
    CHECK(rotation_vector(quaternion_from_rotation_vector(v)).y() == Approx(angle).epsilon(1e-14));
  }
}

TEST_CASE("the product of quaternions is the product of matrices") {
  const Vec4 a = quaternion_from_rotation_vector(vectors[0]),
             b = quaternion_from_rotation_vector(Vec3(2, 1, 0.5));
  CHECK(
      (rotation_matrix(quaternion_product(a, b)) - rotation_matrix(a) * rotation_matrix(b)).norm() <
      1e-14);
  CHECK((rotation_matrix(quaternion_inverse(a)) - rotation_matrix(a).transpose()).norm() < 1e-15);
}

TEST_CASE(
    "turning with the angular velocity between two orientations leads from one to the other") {
  const Vec4 a = quaternion_from_rotation_vector(vectors[0]),
             b = quaternion_from_rotation_vector(Vec3(1.0, -0.4, 0.5));
  const Vec3 omega = angular_velocity_between(a, b, 0.25);
  CHECK((turned(a, omega, 0.25) - b).norm() < 1e-14);
  // The negated quaternion is the same rotation and causes no extra turn of 2 pi.
  CHECK((angular_velocity_between(a, -b, 0.25) - omega).norm() < 1e-13);
  CHECK((nearer_sign(-b, a) - nearer_sign(b, a)).norm() == 0.0);
}

TEST_CASE("spherical interpolation has constant angular velocity") {
  const Vec4 a = quaternion_from_rotation_vector(vectors[0]),
             b = quaternion_from_rotation_vector(Vec3(1.0, -0.4, 0.5));
  CHECK((slerp(a, b, 0.0) - a).norm() < 1e-15);
  CHECK((slerp(a, b, 1.0) - b).norm() < 1e-14);
  const Vec3 first = angular_velocity_between(slerp(a, b, 0.0), slerp(a, b, 0.1), 0.1);
  const Vec3 last = angular_velocity_between(slerp(a, b, 0.9), slerp(a, b, 1.0), 0.1);
  CHECK((first - last).norm() < 1e-13);
  // The result agrees with Eigen's formula.
  CHECK((slerp(a, b, 0.3) - to_vector(to_quaternion(a).slerp(0.3, to_quaternion(b)))).norm() <
        1e-14);
}
