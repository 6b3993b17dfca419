#include <catch2/catch.hpp>

#include <Eigen/Eigenvalues>
#include <random>

#include "core/linalg/small.h"

using namespace loomstone;

TEST_CASE("the inverse of a positive definite block is exact to rounding and others are refused") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    const Mat3 root = Mat3::NullaryExpr([&] { return number(random); });
    const Mat3 a = root * root.transpose() + 0.1 * Mat3::Identity();
    Mat3 inverse = Mat3::Zero();
    REQUIRE(invert_positive_definite(a, inverse));
    // Condition numbers stay below 50.
    CHECK((a * inverse - Mat3::Identity()).norm() < 1e-12);
    Mat3 bad = a;
    bad(i % 3, i % 3) = -0.1;
    CHECK_FALSE(invert_positive_definite(bad, inverse));
    bad(i % 3, i % 3) = std::nan("");
    CHECK_FALSE(invert_positive_definite(bad, inverse));
  }
}
