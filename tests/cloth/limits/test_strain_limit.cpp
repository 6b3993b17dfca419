// Tests of limiting the strain of one triangle.
#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "core/base/error.h"
#include "tests/cloth/limits/limit_support.h"
#include "tests/support/decompositions.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// Returns the corners of a triangle that is strained by U = I + strain in its plane, and then
// rotated by `turn` and translated in space.
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
  return (Eigen::AngleAxisd(0.7 * i, Vec3(1, 2, -1).normalized()) *
          Eigen::AngleAxisd(1.3 * i, Vec3::UnitZ()))
      .toRotationMatrix();
}

// Displacements that solve the six equations (3.10) of [Thomaszewski2010]: for the three strains,
// for linear momentum in the plane, and for angular momentum about the centre of mass.
Points thesis_correction(const LimitedCloth& cloth, const Points& x, const Vec3& change) {
  const Corners2& c = cloth.corners[0];
  const Vec2 e1 = (c.row(1) - c.row(0)).transpose(), e2 = (c.row(2) - c.row(0)).transpose();
  Mat2 dm;
  dm << e1, e2;
  Mat32 ds;
  ds << (x.row(1) - x.row(0)).transpose(), (x.row(2) - x.row(0)).transpose();
  const Mat32 f = ds * dm.inverse();
  const Mat32 r = test::polar_rotation(f);
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
    a(5, 2 * k) = -cloth.mass[k] * l.y() / cloth.mass.sum(),
             a(5, 2 * k + 1) = cloth.mass[k] * l.x() / cloth.mass.sum();
  }
  Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
  b.head<3>() = change;
  const Eigen::Matrix<double, 6, 1> s = test::solution(a, b);
  Points moved(3, 3);
  for (int k = 0; k < 3; ++k) moved.row(k) = (r * s.segment<2>(2 * k)).transpose();
  return moved;
}

// Positions after one sweep with a tolerance far below the excess.
Points corrected(const LimitedCloth& cloth, const Points& x, const char* method = "gauss-seidel") {
  StrainLimiter limiter(cloth, sweeping(method, 1e-15, 1));
  Points moved = x;
  limiter.enforce({}, 1, {}, moved);
  return moved;
}

constexpr StrainLimit tight() {
  return {0.05, 0.02, 0.1, -0.03, -0.01, std::nullopt, std::nullopt};
}

}  // namespace

TEST_CASE("strain is U - I in the axes of the cloth for any rotation in space") {
  for (const Corners2& shape : shapes())
    for (int i = 0; i < 5; ++i) {
      const Vec3 strain(0.13, -0.21, 0.07);
      const LimitedCloth cloth = one_triangle(shape, Vec3::Ones(), tight());
      // The rounding error is 1e-16 at coordinates of 1 m, divided by the sliver's height, 2e-4 m.
      CHECK((strain_of(cloth, strained(shape, strain, some_turn(i))).row(0).transpose() - strain)
                .norm() < 1e-11);
    }
}

TEST_CASE(
    "a correction keeps linear and angular momentum and equals the solution of the thesis' six "
    "equations") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> mass(0.5, 2.0), strain(-0.3, 0.5);
  for (const Corners2& shape : shapes())
    for (int i = 0; i < 6; ++i)
      for (int first = 0; first < 3; ++first) {  // cyclic renumbering of the corners
        Corners2 corners;
        for (int k = 0; k < 3; ++k) corners.row(k) = shape.row((k + first) % 3);
        const LimitedCloth cloth =
            one_triangle(corners, Vec3(mass(random), mass(random), mass(random)), tight());
        const Points x =
            strained(corners, {strain(random), strain(random), 0.5 * strain(random)}, some_turn(i));
        const Points shift = corrected(cloth, x) - x;
        const double size = shift.rowwise().norm().maxCoeff();
        REQUIRE(size > 1e-5);
        CHECK(momentum(cloth.mass, shift).norm() < 1e-14);
        const Vec3 centre = (x.transpose() * cloth.mass) / cloth.mass.sum();
        CHECK(angular_momentum(cloth.mass, x.rowwise() - centre.transpose(), shift).norm() <
              1e-15 * 0.03);
        const Vec3 before = strain_of(cloth, x).row(0).transpose();
        Vec3 target;
        target << std::clamp(before[0], -0.03, 0.05), std::clamp(before[1], -0.01, 0.02),
            std::clamp(before[2], -0.1, 0.1);
        // The tolerance allows for rounding errors of coordinates of 1 m. The strain divides them
        // by the triangle's height, and the correction multiplies them by its longest side.
        CHECK((thesis_correction(cloth, x, target - before) - shift).norm() < 1e-11 * size + 1e-13);
        const Points moved = x + shift;
        CHECK((corrected(cloth, x, "gauss-seidel-random") - moved).norm() == 0.0);
        CHECK((corrected(cloth, x, "jacobi") - moved).norm() < 1e-15);
      }
}

TEST_CASE(
    "a triangle meets its target for a fixed rotation; for the new rotation the error is "
    "quadratic") {
  double last = 1e9;
  for (double scale = 0.4; scale > 0.04; scale *= 0.5) {  // scales strain and upper limits
    double worst = 0.0;
    for (const Corners2& shape : shapes()) {
      const Vec3 mass(1.0, 2.0, 0.7);
      const StrainLimit limit{0.5 * scale, 0.2 * scale,  0.1 * scale, -1.0,
                              -1.0,        std::nullopt, std::nullopt};
      const LimitedCloth cloth = one_triangle(shape, mass, limit);
      const Points x = strained(shape, Vec3(1.0, 0.1, -0.6) * scale, some_turn(3));
      const Points moved = corrected(cloth, x);
      // Undoes some_turn(3), the rotation R of x. For this rotation, the strain of the corrected
      // triangle is the symmetric part of F - I.
      Mat2 dm, ds;
      dm << (shape.row(1) - shape.row(0)).transpose(), (shape.row(2) - shape.row(0)).transpose();
      Points flat = moved * some_turn(3);
      ds << (flat.row(1) - flat.row(0)).transpose().head<2>(),
          (flat.row(2) - flat.row(0)).transpose().head<2>();
      const Mat2 f = ds * dm.inverse();
      // The rounding error is that of coordinates of 1 m, divided by the sliver's height.
      const double tolerance = 1e-15 / 2e-4 * 10;
      CHECK(f(0, 0) - 1 == Approx(0.5 * scale).margin(tolerance));
      CHECK(f(1, 1) - 1 == Approx(0.1 * scale).margin(tolerance));
      CHECK(0.5 * (f(0, 1) + f(1, 0)) == Approx(-0.1 * scale).margin(tolerance));
      const double remainder =
          (strain_of(cloth, moved).row(0).transpose() - Vec3(0.5, 0.1, -0.1) * scale)
              .cwiseAbs()
              .maxCoeff();
      worst = std::max(worst, remainder);
    }
    CHECK(worst < last / 3.2);  // last / worst tends to 4 as the strain decreases
    last = worst;
  }
  CHECK(last > 1e-7);  // an error remains, because the rotation changes
}

TEST_CASE(
    "with one prescribed corner strain is met and angular momentum about it is conserved; with two "
    "the nearest strain is reached; with three nothing moves") {
  const StrainLimit limit{0.05, 0.05, 0.02, -1.0, -1.0, std::nullopt, std::nullopt};
  for (const Corners2& shape : shapes())
    for (int corner = 0; corner < 3; ++corner) {
      LimitedCloth cloth = one_triangle(shape, Vec3(1.0, 2.0, 0.7), limit);
      const Points x = strained(shape, Vec3(0.051, 0.02, 0.021), some_turn(2));
      cloth.prescribed[corner] = 1;
      const Points one = corrected(cloth, x);
      CHECK(one.row(corner) == x.row(corner));
      // The correction assumes a fixed rotation, but rotates the triangle by up to 1e-3 rad. This
      // causes errors of up to 2e-5 in strains of up to 0.05. The tolerance is ten times as large.
      CHECK((strain_of(cloth, one).row(0).transpose() - Vec3(0.05, 0.02, 0.02))
                .cwiseAbs()
                .maxCoeff() < 2e-4);
      const Points arms = x.rowwise() - x.row(corner);
      CHECK(angular_momentum(cloth.mass, arms, one - x).norm() < 1e-17);
      for (int free = 0; free < 3; ++free) {
        if (free == corner) continue;
        cloth.prescribed = {1, 1, 1};
        cloth.prescribed[free] = 0;
        const Points two = corrected(cloth, x);
        for (int k = 0; k < 3; ++k) CHECK((k == free || two.row(k) == x.row(k)));
        // Small in-plane displacements of the free corner away from the result take the strain
        // tensor farther from the target.
        const auto miss = [&](const Points& p) {
          const Vec3 e = strain_of(cloth, p).row(0).transpose() - Vec3(0.05, 0.02, 0.02);
          return e[0] * e[0] + e[1] * e[1] + 2 * e[2] * e[2];
        };
        const Vec3 a = (x.row((free + 1) % 3) - x.row(free)).transpose(),
                   b = (x.row((free + 2) % 3) - x.row(free)).transpose();
        for (const Vec3& way : {a, b, Vec3(-a), Vec3(-b)}) {
          Points beside = two;
          beside.row(free) += 0.003 * way.transpose();
          CHECK(miss(two) < miss(beside));
        }
        CHECK(miss(two) < miss(x));
      }
      cloth.prescribed = {1, 1, 1};
      CHECK(corrected(cloth, x) == x);
    }
}

TEST_CASE("collapsed and inverted triangles give finite numbers") {
  const StrainLimit limit{0.05, 0.05, 0.02, -0.5, -0.5, std::nullopt, std::nullopt};
  for (const Corners2& shape : shapes()) {
    const LimitedCloth cloth = one_triangle(shape, Vec3(1.0, 2.0, 0.7), limit);
    Points line(3, 3), point = Points::Zero(3, 3);
    line << 0, 0, 0, 0.01, 0, 0, 0.02, 0, 0;
    const Points over =
        strained(shape, Vec3(0.1, 0.0, 0.0),
                 Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()).toRotationMatrix());
    for (const Points& x : {line, point, over})
      for (const char* method : {"gauss-seidel", "gauss-seidel-random", "jacobi", "edges"}) {
        StrainLimiter limiter(cloth, sweeping(method, 1e-6, 20));
        Points moved = x;
        const LimitReport report = limiter.enforce({}, 1, {}, moved);
        CHECK(moved.allFinite());
        CHECK(std::isfinite(report.largest()));
      }
    CHECK((strain_of(cloth, over).row(0) -
           Points(strain_of(cloth, strained(shape, Vec3(0.1, 0.0, 0.0), Mat3::Identity()))).row(0))
              .norm() < 1e-11);
  }
}

TEST_CASE(
    "axes at 45 degrees to a uniaxial pull have half of it as weft, warp and shear; limiting shear "
    "agrees with the closed form") {
  const double pull = 0.2, most = 0.03, c = std::sqrt(0.5);
  Corners2 turned = shapes()[0];  // equilateral
  Points x(3, 3);
  for (int k = 0; k < 3; ++k) {
    x.row(k) << (1 + pull) * turned(k, 0), turned(k, 1), 0.0;
    const Vec2 p = turned.row(k).transpose();
    turned.row(k) << c * (p.x() + p.y()), c * (p.y() - p.x());
  }
  const StrainLimit limit{1.0, 1.0, most, -1.0, -1.0, std::nullopt, std::nullopt};
  const LimitedCloth cloth = one_triangle(turned, Vec3::Ones(), limit);
  const Vec3 before = strain_of(cloth, x).row(0).transpose(),
             after = strain_of(cloth, corrected(cloth, x)).row(0).transpose();
  CHECK((before - Vec3(pull / 2, pull / 2, before[2] > 0 ? pull / 2 : -pull / 2)).norm() < 1e-13);
  CHECK(std::abs(before[2]) == Approx(pull / 2));
  // The result is exact, because the correction does not rotate this triangle.
  CHECK((after - Vec3(pull / 2, pull / 2, before[2] > 0 ? most : -most)).norm() < 1e-13);
}
