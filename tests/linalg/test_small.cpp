#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include "core/linalg/small.h"
#include "tests/support/decompositions.h"

using namespace loomstone;

namespace {

// Positive part of a matrix, computed by Eigen's iterative eigensolver.
template <class Matrix>
Matrix positive_part_by_iteration(const Matrix& a) {
  const Eigen::MatrixXd vectors = test::eigenvectors(a);
  return vectors * test::eigenvalues(a).cwiseMax(0.0).asDiagonal() * vectors.transpose();
}

template <class Matrix>
Matrix turned_diagonal(const Matrix& random,
                       const Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1>& eigenvalues) {
  const Matrix vectors = test::eigenvectors(random + random.transpose());
  const Matrix made = vectors * eigenvalues.asDiagonal() * vectors.transpose();
  return 0.5 * (made + made.transpose());
}

}  // namespace

TEST_CASE(
    "positive parts agree with an iterative eigensolver, repeated and vanishing eigenvalues "
    "included") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  const double values[] = {0.0, 1.0, -1.0, 1.0 + 1e-9, -1.0 - 1e-9, 1e-12, -1e-12, 3.0, -1e3};
  for (const double first : values)
    for (const double second : values) {
      const Mat2 random2 = Mat2::NullaryExpr([&] { return number(random); });
      const Mat2 a2 = turned_diagonal<Mat2>(random2, Vec2(first, second));
      // The tolerances allow for rounding errors, which are proportional to the norm of the matrix.
      CHECK((positive_part(a2) - positive_part_by_iteration(a2)).norm() <= 1e-14 * a2.norm());
      for (const double third : values) {
        const Mat3 random3 = Mat3::NullaryExpr([&] { return number(random); });
        const Mat3 a3 = turned_diagonal<Mat3>(random3, Vec3(first, second, third));
        INFO(first << " " << second << " " << third);
        CHECK((positive_part(a3) - positive_part_by_iteration(a3)).norm() <= 2e-14 * a3.norm());
      }
    }
}

TEST_CASE("the positive part of a positive matrix is itself and of a negative one is zero") {
  Mat2 a;
  a << 2.0, 1.0, 1.0, 3.0;
  CHECK(positive_part(a) == a);
  CHECK(positive_part(Mat2(-a)).isZero(0.0));
  CHECK(positive_part(Mat3(Mat3::Zero())).isZero(0.0));
  CHECK((positive_part(Mat3(-Mat3::Identity()))).isZero(0.0));
}

TEST_CASE("the polar rotation leaves a symmetric positive stretch") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (int i = 0; i < 100; ++i) {
    Mat2 f = Mat2::NullaryExpr([&] { return number(random); });
    if (f.determinant() < 0.0) f.col(0) *= -1.0;
    const Mat2 rotation = polar_rotation(f), stretch = rotation.transpose() * f;
    CHECK((rotation.transpose() * rotation - Mat2::Identity()).norm() < 1e-15);
    CHECK(std::abs(stretch(0, 1) - stretch(1, 0)) < 1e-15);
    CHECK(symmetric_eigenvalues(stretch).minCoeff() > 0.0);
  }
}

TEST_CASE("the inverse of a positive definite block is exact to rounding and others are refused") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    const Mat3 root = Mat3::NullaryExpr([&] { return number(random); });
    const Mat3 a = root * root.transpose() + 0.1 * Mat3::Identity();
    Mat3 inverse = Mat3::Zero();
    REQUIRE(invert_positive_definite(a, inverse));
    // The eigenvalues of `a` are between 0.1 and 9.1, so its condition number is below 100.
    CHECK((a * inverse - Mat3::Identity()).norm() < 1e-12);
    Mat3 bad = a;
    bad(i % 3, i % 3) = -0.1;
    CHECK_FALSE(invert_positive_definite(bad, inverse));
    bad(i % 3, i % 3) = std::nan("");
    CHECK_FALSE(invert_positive_definite(bad, inverse));
  }
}
