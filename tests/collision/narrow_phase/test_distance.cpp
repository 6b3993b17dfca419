#include <catch2/catch.hpp>

#include "core/collision/narrow_phase/crossing.h"
#include "core/collision/narrow_phase/distance.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;

namespace {

// Smallest distance over a grid of barycentric weights with n intervals per side.
double sampled_distance(const FourPoints& p, bool face, int n) {
  double best = INFINITY;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= (face ? n - i : n); ++j) {
      const double s = double(i) / n, t = double(j) / n;
      const Vec3 difference = face ? Vec3(p[0] - p[1] - s * (p[2] - p[1]) - t * (p[3] - p[1]))
                                   : Vec3(p[0] + s * (p[1] - p[0]) - p[2] - t * (p[3] - p[2]));
      best = std::min(best, difference.norm());
    }
  return best;
}

void check_against_sampling(const FourPoints& p, bool face) {
  const ClosestPair closest = face ? closest_vertex_face(p) : closest_edge_edge(p);
  const int n = 60;
  const double sampled = sampled_distance(p, face, n);
  double size = 0.0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j) size = std::max(size, (p[i] - p[j]).norm());
  // In s and in t, a grid point lies within half an interval of the closest point. The sampled
  // distance is therefore too large by at most size / n, and the tolerance has a margin.
  CHECK(closest.distance <= sampled + 1e-12 * size);
  CHECK(closest.distance >= sampled - 1.5 * size / n);
  Vec3 difference = Vec3::Zero();
  double sum_a = 0.0, sum_b = 0.0;
  for (int i = 0; i < 4; ++i) {
    difference += closest.weights[i] * p[i];
    const bool on_a = i < (face ? 1 : 2);
    (on_a ? sum_a : sum_b) += closest.weights[i];
    CHECK((on_a ? closest.weights[i] : -closest.weights[i]) >= 0.0);
  }
  CHECK(sum_a == Approx(1.0).epsilon(1e-12));
  CHECK(sum_b == Approx(-1.0).epsilon(1e-12));
  CHECK((difference - closest.difference).norm() <= 1e-10 * size);
}

}  // namespace

TEST_CASE("closest points agree with a fine sampling, and the weights reproduce them") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    FourPoints p;
    for (Vec3& point : p) point = random_vector(random, 1.0);
    if (trial % 4 == 1)
      p[3] = p[2] + 1e-9 * random_vector(random, 1.0);      // side of almost zero length
    if (trial % 4 == 2) p[3] = p[2] + (p[1] - p[0]) * 0.7;  // parallel edges
    if (trial % 4 == 3) p[3] = 0.5 * (p[1] + p[2]) + 1e-10 * random_vector(random, 1.0);  // sliver
    check_against_sampling(p, true);
    check_against_sampling(p, false);
  }
}

TEST_CASE("the distance to a triangle without area is that to its edges") {
  const FourPoints p = {Vec3(0.5, 1, 0), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)};
  CHECK(closest_vertex_face(p).distance == 1.0);
  const FourPoints point = {Vec3(0, 3, 4), Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)};
  CHECK(closest_vertex_face(point).distance == 5.0);
  // The first edge ends at the origin, and the second edge has zero length there.
  CHECK(closest_edge_edge(point).distance == Approx(0.0).margin(1e-15));
}

TEST_CASE("at zero distance the normal is that of the features, oriented to the given side") {
  const FourPoints face = {Vec3(0.2, 0.2, 0), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  CHECK(contact_normal_vertex_face(face, closest_vertex_face(face), Vec3(0, 0, -1)) ==
        Vec3(0, 0, -1));
  const FourPoints edges = {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 1, 0)};
  CHECK(contact_normal_edge_edge(edges, closest_edge_edge(edges), Vec3(0, 0, -1)) ==
        Vec3(0, 0, -1));
}

TEST_CASE("edges that move less than the bound do not come closest inside both edges") {
  std::mt19937 random(5);
  const double thickness = 0.2;
  int bounded = 0, crossed = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    FourPoints p;
    for (Vec3& point : p) point = random_vector(random, 1.0);
    p[2].z() *= 0.2, p[3].z() *= 0.2, p[0].z() *= 0.2, p[1].z() *= 0.2;  // many pairs are close
    if (trial % 4 == 0) p[3] = p[2] + 0.7 * (p[1] - p[0]) + random_vector(random, 1e-3);
    const double motion = motion_to_cross(p, thickness);
    if (closest_edge_edge(p).interior) {
      CHECK(motion < 1e-12);  // zero up to rounding
      continue;
    }
    bounded += motion > 0.01;
    for (const double share : {1.0, 8.0}) {
      const auto crosses = [&] {
        FourPoints moved = p;
        for (Vec3& point : moved)
          point += 0.5 * share * motion * random_vector(random, 1.0).normalized();
        const ClosestPair closest = closest_edge_edge(moved);
        return closest.interior && closest.distance < thickness;
      };
      for (int k = 0; k < 20; ++k) {
        if (share == 1.0) REQUIRE(!crosses());
        if (share > 1.0) crossed += crosses();
      }
    }
  }
  CHECK(bounded > 1000);
  CHECK(crossed > 1000);  // longer motions do cross
  // Seen from above, the first edge begins at a distance g from the second one, so that they cross
  // after a relative motion of g.
  const double g = 0.05;
  const FourPoints apart = {Vec3(g, 0, 0.1), Vec3(1, 0, 0.1), Vec3(0, -1, 0), Vec3(0, 1, 0)};
  CHECK(motion_to_cross(apart, thickness) <= g);
  CHECK(motion_to_cross(apart, thickness) > 0.6 * g);
}
