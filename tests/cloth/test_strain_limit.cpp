// One triangle against its limits.
#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "core/base/error.h"
#include "tests/cloth/limit_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// The triangle strained by U = I + strain in its plane, turned in space and moved.
Points strained(const Corners2& corners, const Vec3& strain, const Mat3& turn) {
  Mat2 u;
  u << 1 + strain[0], strain[2], strain[2], 1 + strain[1];
  Points x(3, 3);
  for (int k = 0; k < 3; ++k) {
    const Vec2 p = u * corners.row(k).transpose();
    x.row(k) = (turn * Vec3(p.x(), p.y(), 0.0) + Vec3(0.3, -0.2, 0.7)).transpose();
  }
  return x;
}

Mat3 some_turn(int i) {
  return (Eigen::AngleAxisd(0.7 * i, Vec3(1, 2, -1).normalized()) * Eigen::AngleAxisd(1.3 * i, Vec3::UnitZ())).toRotationMatrix();
}

// Thesis (3.10), 6 x 6: strain rows, linear momentum, angular momentum about the centre of the candidate positions.
Points thesis_correction(const LimitedCloth& cloth, const Points& x, const Vec3& change) {
  const Corners2& c = cloth.corners[0];
  const Vec2 e1 = (c.row(1) - c.row(0)).transpose(), e2 = (c.row(2) - c.row(0)).transpose();
  Mat2 dm;
  dm << e1, e2;
  Mat32 ds;
  ds << (x.row(1) - x.row(0)).transpose(), (x.row(2) - x.row(0)).transpose();
  const Mat32 f = ds * dm.inverse();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(f), Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Mat32 r = svd.matrixU() * svd.matrixV().transpose();
  const Mat2 inverse = dm.inverse();
  Vec2 g[3];
  g[1] = inverse.row(0).transpose(), g[2] = inverse.row(1).transpose(), g[0] = -(g[1] + g[2]);
  Vec3 centre = Vec3::Zero();
  for (int k = 0; k < 3; ++k) centre += cloth.mass[k] / cloth.mass.sum() * x.row(k).transpose();
  Eigen::Matrix<double, 6, 6> a = Eigen::Matrix<double, 6, 6>::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec2 l = r.transpose() * (x.row(k).transpose() - centre);
    a(0, 2 * k) = g[k].x();
    a(1, 2 * k + 1) = g[k].y();
    a(2, 2 * k) = 0.5 * g[k].y(), a(2, 2 * k + 1) = 0.5 * g[k].x();
    a(3, 2 * k) = a(4, 2 * k + 1) = cloth.mass[k] / cloth.mass.sum();
    a(5, 2 * k) = -cloth.mass[k] * l.y() / cloth.mass.sum(), a(5, 2 * k + 1) = cloth.mass[k] * l.x() / cloth.mass.sum();
  }
  Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
  b.head<3>() = change;
  const Eigen::Matrix<double, 6, 1> s = a.fullPivLu().solve(b);
  Points moved(3, 3);
  for (int k = 0; k < 3; ++k) moved.row(k) = (r * s.segment<2>(2 * k)).transpose();
  return moved;
}

// One sweep with a tolerance far below what is violated.
Points corrected(const LimitedCloth& cloth, const Points& x, const char* method = "gauss-seidel") {
  StrainLimiter limiter(cloth, sweeping(method, 1e-15, 1));
  Points moved = x;
  limiter.enforce({}, 1, {}, moved);
  return moved;
}

constexpr StrainLimit tight() { return {0.05, 0.02, 0.1, -0.03, -0.01, std::nullopt, std::nullopt}; }

}  // namespace

TEST_CASE("strain is U - I in the axes of the cloth, whatever the turn in space") {
  for (const Corners2& shape : shapes())
    for (int i = 0; i < 5; ++i) {
      const Vec3 strain(0.13, -0.21, 0.07);
      const LimitedCloth cloth = one_triangle(shape, Vec3::Ones(), tight());
      // 1e-16 over the height of the sliver, 2e-4 m, at coordinates of 1 m.
      CHECK((strain_of(cloth, strained(shape, strain, some_turn(i))).row(0).transpose() - strain).norm() < 1e-11);
    }
}

TEST_CASE("a correction keeps linear and angular momentum and equals the solution of the thesis' six equations") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> mass(0.5, 2.0), strain(-0.3, 0.5);
  for (const Corners2& shape : shapes())
    for (int i = 0; i < 6; ++i)
      for (int first = 0; first < 3; ++first) {  // renumbered
        Corners2 corners;
        for (int k = 0; k < 3; ++k) corners.row(k) = shape.row((k + first) % 3);
        const LimitedCloth cloth = one_triangle(corners, Vec3(mass(random), mass(random), mass(random)), tight());
        const Points x = strained(corners, {strain(random), strain(random), 0.5 * strain(random)}, some_turn(i));
        const Points shift = corrected(cloth, x) - x;
        const double size = shift.rowwise().norm().maxCoeff();
        REQUIRE(size > 1e-5);
        CHECK(momentum(cloth.mass, shift).norm() < 1e-14);
        const Vec3 centre = (x.transpose() * cloth.mass) / cloth.mass.sum();
        CHECK(angular_momentum(cloth.mass, x.rowwise() - centre.transpose(), shift).norm() < 1e-15 * 0.03);
        const Vec3 before = strain_of(cloth, x).row(0).transpose();
        Vec3 target;
        target << std::clamp(before[0], -0.03, 0.05), std::clamp(before[1], -0.01, 0.02), std::clamp(before[2], -0.1, 0.1);
        // Rounding of coordinates of 1 m over the height of the triangle, times its longest side.
        CHECK((thesis_correction(cloth, x, target - before) - shift).norm() < 1e-11 * size + 1e-13);
        // With R held the target is met: the symmetric part of R^T (F + dF).
        const Points moved = x + shift;
        CHECK((corrected(cloth, x, "gauss-seidel-random") - moved).norm() == 0.0);
        CHECK((corrected(cloth, x, "jacobi") - moved).norm() < 1e-15);
      }
}
