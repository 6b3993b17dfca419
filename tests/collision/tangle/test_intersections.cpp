#include <catch2/catch.hpp>

#include "core/collision/narrow_phase/exact_predicates.h"
#include "core/collision/tangle/intersections.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;

TEST_CASE(
    "orientations of integer points equal those of integer arithmetic, also where they vanish") {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> small(-3, 3), large(-1000000, 1000000);
  int zeros = 0;
  for (int trial = 0; trial < 100000; ++trial) {
    long long p[4][3];
    for (auto& point : p)
      for (long long& c : point) c = trial % 2 ? small(random) : large(random);
    if (trial % 4 == 0)  // exactly coplanar
      for (int k = 0; k < 3; ++k)
        p[3][k] = p[0][k] + 2 * (p[1][k] - p[0][k]) - 3 * (p[2][k] - p[0][k]);
    __int128 u[3][3];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) u[i][k] = p[i][k] - p[3][k];
    const __int128 d = u[0][0] * (u[1][1] * u[2][2] - u[1][2] * u[2][1]) +
                       u[0][1] * (u[1][2] * u[2][0] - u[1][0] * u[2][2]) +
                       u[0][2] * (u[1][0] * u[2][1] - u[1][1] * u[2][0]);
    const int truth = (d > 0) - (d < 0);
    zeros += truth == 0;
    // Scaling by a power of two and shifting keep these coordinates exact.
    Vec3 q[4];
    for (int i = 0; i < 4; ++i)
      q[i] = Vec3(p[i][0], p[i][1], p[i][2]) * 0x1p-20 + Vec3(4096, 0, -8);
    if (orientation(q[0], q[1], q[2], q[3]) != truth) FAIL_CHECK("trial " << trial);
  }
  CHECK(zeros > 20000);
}

TEST_CASE("orientation changes sign by one unit in the last place") {
  const Vec3 a(0.1, 0.2, 0.3), b(1.1, 0.2, 0.3), c(0.1, 1.2, 0.3);
  for (const double z : {0.3, std::nextafter(0.3, 1.0), std::nextafter(0.3, 0.0)}) {
    const int expected = (z < 0.3) - (z > 0.3);
    CHECK(orientation(a, b, c, Vec3(0.7, 0.6, z)) == expected);
  }
}

TEST_CASE("triangles that cross, touch or contain each other meet; triangles 1e-300 apart do not") {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto meets = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
    const bool one = triangles_meet(a, b, c, p, q, r), other = triangles_meet(r, p, q, b, c, a);
    CHECK(one == other);
    return one;
  };
  const double hair = 1e-300;
  CHECK(meets({0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.9, 0.9, 1}));  // an edge pierces
  CHECK(meets({0.2, 0.2, 0}, {0.2, 0.2, 1}, {0.9, 0.9, 1}));   // vertex on face
  CHECK_FALSE(meets({0.2, 0.2, hair}, {0.2, 0.2, 1}, {0.9, 0.9, 1}));
  CHECK(meets({0.5, -1, 0}, {0.5, 1, 0}, {0.5, 0, 1}));       // edge in the plane
  CHECK(meets({0, 0, 0}, {-1, 0, 0}, {0, -1, 0}));            // corner on corner, same plane
  CHECK(meets({0.1, 0.1, 0}, {0.2, 0.1, 0}, {0.1, 0.2, 0}));  // inside, same plane
  CHECK(meets({-5, -5, 0}, {5, -5, 0}, {0, 9, 0}));           // encloses the other, same plane
  CHECK_FALSE(meets({1, 1, 0}, {2, 1, 0}, {1, 2, 0}));        // side by side, same plane
  CHECK(meets({0.5, 0.5, -1}, {0.5, 0.5, 1}, {2, 2, 0}));     // through the long edge
  CHECK_FALSE(
      meets({0.5, std::nextafter(0.5, 1.0), -1}, {0.5, std::nextafter(0.5, 1.0), 1}, {2, 2, 0}));
  CHECK(meets({0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.2, 0.2, 2}));  // a degenerate triangle pierces
}

TEST_CASE("intersecting pairs agree with a test of all pairs, and none share a vertex") {
  TestScene scene =
      make_scene({{icosphere(0.1, 2)}, {grid_cells(0.3, 0.3, 12, 12).moved(Vec3(0, 0, 0.013))}});
  const Points x = shaken(scene.x, 0.01, 5);
  const auto pairs = intersecting_pairs(x, scene.model.triangles);
  std::vector<std::array<Index, 2>> all;
  const Triangles& f = scene.model.triangles;
  for (Index i = 0; i < f.rows(); ++i)
    for (Index j = i + 1; j < f.rows(); ++j) {
      bool shared = false;
      for (int k = 0; k < 9; ++k) shared |= f(i, k / 3) == f(j, k % 3);
      const auto p = [&](Index t, int k) { return Vec3(x.row(f(t, k)).transpose()); };
      if (!shared && triangles_meet(p(i, 0), p(i, 1), p(i, 2), p(j, 0), p(j, 1), p(j, 2)))
        all.push_back({i, j});
    }
  CHECK(pairs == all);
  CHECK(pairs.size() > 20);
}
