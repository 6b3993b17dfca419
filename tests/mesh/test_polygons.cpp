#include "core/mesh/polygons.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/base/error.h"

namespace loomstone {
namespace {

Vec3 area_of(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * (b - a).cross(c - a); }

// Checks that the triangles of split_polygon() cover the polygon once: all have the orientation of
// `normal`, and their areas add up to `area`.
void check_split(const std::vector<Vec3>& polygon, const Vec3& normal, double area) {
  const auto triangles = split_polygon(polygon);
  REQUIRE(triangles.size() == polygon.size() - 2);
  double sum = 0.0;
  for (const auto& [a, b, c] : triangles) {
    const Vec3 of_triangle = area_of(polygon[a], polygon[b], polygon[c]);
    CHECK(of_triangle.dot(normal) > 0.0);
    sum += of_triangle.norm();
  }
  CHECK(sum == Catch::Detail::Approx(area).epsilon(1e-12));
}

std::vector<Vec3> rotated(std::vector<Vec3> polygon, int first) {
  std::rotate(polygon.begin(), polygon.begin() + first, polygon.end());
  return polygon;
}

}  // namespace

TEST_CASE("a convex polygon is split into the triangles around its first corner") {
  const std::vector<Vec3> quad = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 0}};
  CHECK(split_polygon(quad) == std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("concave polygons are covered once, whatever their first corner is") {
  const std::vector<Vec3> l_shape = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0},
                                     {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  for (int first = 0; first < 6; ++first) check_split(rotated(l_shape, first), {0, 0, 1}, 3.0);
  const std::vector<Vec3> dart = {{0, 0, 0}, {0, 2, 0}, {0, 0.3, 0.3}, {0, 0, 2}};
  for (int first = 0; first < 4; ++first) check_split(rotated(dart, first), {1, 0, 0}, 0.6);
  // A corner in the middle of an edge must not give a triangle without area.
  const std::vector<Vec3> square = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  for (int first = 0; first < 5; ++first) check_split(rotated(square, first), {0, 0, 1}, 4.0);
}

TEST_CASE("corners in the middle of edges are no obstacle in any plane") {
  const std::vector<Vec3> outline = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1.5, 1, 0},
                                     {1, 1, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}};
  const std::vector<Vec3> notched = {{3, 0, 0}, {4, 1, 0}, {4, 4, 0}, {2, 1, 0}, {3, 1, 0}};
  std::mt19937 random(5);
  std::normal_distribution<double> component;
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::Quaterniond turn = Eigen::Quaterniond(component(random), component(random),
                                                       component(random), component(random))
                                        .normalized();
    const auto turned = [&](std::vector<Vec3> polygon) {
      for (Vec3& corner : polygon) corner = turn * corner;
      return polygon;
    };
    CAPTURE(trial);
    check_split(turned(outline), turn * Vec3(0, 0, 1), 3.0);
    check_split(turned(notched), turn * Vec3(0, 0, 1), 3.5);
  }
}

TEST_CASE("corners that coincide give triangles without area, which other checks refuse") {
  const std::vector<Vec3> pole = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}};
  const auto triangles = split_polygon(pole);
  REQUIRE(triangles.size() == 2);
  double area = 0.0;
  for (const auto& [a, b, c] : triangles) area += area_of(pole[a], pole[b], pole[c]).z();
  CHECK(area == Catch::Detail::Approx(0.5));
}

TEST_CASE("random stars are covered once in any plane") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> radius(0.1, 1.0), coordinate(-1.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 4 + trial % 40;
    const Vec3 normal = Vec3(coordinate(random), coordinate(random), 1.5).normalized();
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
    std::vector<Vec3> star;
    for (int k = 0; k < n; ++k) {
      const double angle = 2.0 * std::acos(-1.0) * k / n, r = radius(random);
      star.push_back(r * (std::cos(angle) * u + std::sin(angle) * v) + Vec3(5, -3, 2));
    }
    double area = 0.0;
    for (int k = 0; k < n; ++k)
      area += area_of(Vec3(5, -3, 2), star[k], star[(k + 1) % n]).dot(normal);
    CAPTURE(trial);
    check_split(star, normal, area);
  }
}

TEST_CASE("an outline that crosses itself gives no triangles, and an error for several polygons") {
  const std::vector<Vec3> crossed = {{0, 0, 0}, {3, 0, 0}, {1, 1, 0}, {2, 1.2, 0}, {0, -1, 0}};
  CHECK(split_polygon(crossed).empty());
  CHECK(split_polygon({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).empty());      // signed area 0
  CHECK(split_polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}).size() == 2);  // on a line
  Points corners(8, 3);
  corners << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 3, 0, 0, 1, 1, 0, 2, 1.2, 0, 0, -1, 0;
  CHECK_THROWS_WITH(split_polygons(corners, {0, 3, 8}),
                    Catch::Contains("face 1: its outline must not cross itself"));
  CHECK(split_polygons(corners, {0, 2, 3, 3}).rows() == 0);  // fewer than three corners each
  CHECK_THROWS_WITH(split_polygons(corners, {0, 9}), Catch::Contains("start must ascend"));
}

}  // namespace loomstone
