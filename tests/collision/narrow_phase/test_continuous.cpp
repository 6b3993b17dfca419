#include <catch2/catch.hpp>

#include "core/collision/narrow_phase/continuous.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;

namespace {

double distance_at(const MovingPoints& q, bool face, double time) {
  FourPoints p;
  for (int i = 0; i < 4; ++i) p[i] = (1.0 - time) * q[i] + time * q[4 + i];
  return face ? closest_vertex_face(p).distance : closest_edge_edge(p).distance;
}

Impact test(const MovingPoints& q, bool face, double floor = 0.0) {
  return face ? continuous_vertex_face(q, floor) : continuous_edge_edge(q, floor);
}

MovingPoints random_motion(std::mt19937& random, double size, double travel) {
  MovingPoints q;
  for (int i = 0; i < 4; ++i) q[i] = random_vector(random, size);
  for (int i = 0; i < 4; ++i) q[4 + i] = q[i] + random_vector(random, travel);
  return q;
}

}  // namespace

TEST_CASE("a vertex that falls through a face is hit at half time") {
  const MovingPoints q = {Vec3(0.2, 0.2, 1),  Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0),
                          Vec3(0.2, 0.2, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const Impact impact = continuous_vertex_face(q);
  CHECK(impact.hit);
  // The minimum gap is 0, so the reported time is exact up to rounding.
  CHECK(impact.time == Approx(0.5).epsilon(1e-9));
  CHECK((impact.normal - Vec3(0, 0, 1)).norm() < 1e-9);
}

TEST_CASE("edges that pass through each other are reported at any speed") {
  for (const double speed : {1e-3, 1.0, 1e3, 1e6}) {
    const double t = 0.25;
    const MovingPoints q = {
        Vec3(-1, 0, t * speed),       Vec3(1, 0, t * speed),       Vec3(0, -1, 0), Vec3(0, 1, 0),
        Vec3(-1, 0, (t - 1) * speed), Vec3(1, 0, (t - 1) * speed), Vec3(0, -1, 0), Vec3(0, 1, 0)};
    const Impact impact = continuous_edge_edge(q);
    CHECK(impact.hit);
    CHECK(impact.time <= 0.25);
    CHECK(impact.time == Approx(0.25).epsilon(1e-6));
  }
}

TEST_CASE(
    "a motion reported as free keeps the minimum gap, and every motion keeps it until the time of "
    "impact") {
  std::mt19937 random(2);
  int hits = 0, false_hits = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const bool face = trial % 2;
    const MovingPoints q = random_motion(random, 1.0, trial % 3 ? 1.5 : 0.3);
    const double floor = trial % 5 ? 0.0 : 0.01;
    const Impact impact = test(q, face, floor);
    double smallest = INFINITY;
    for (int k = 0; k <= 400; ++k) {
      const double time = k / 400.0, distance = distance_at(q, face, time);
      smallest = std::min(smallest, distance);
      if (time <= impact.time) CHECK(distance >= floor * (1.0 - 1e-12));
    }
    if (impact.hit) {
      ++hits;
      // Between samples, the distance differs from its value at the nearest sample by at most the
      // relative motion in half an interval.
      false_hits += smallest > floor * 1.01 + 6.0 * 1.5 / 800.0;
    } else {
      CHECK(smallest > floor);
    }
  }
  CHECK(hits > 200);
  CHECK(false_hits == 0);
}

TEST_CASE("motions constructed to collide are always reported") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int trial = 0; trial < 20000; ++trial) {
    const bool face = trial % 2;
    const double size = std::pow(10.0, -6.0 * uniform(random)), meeting_time = uniform(random);
    MovingPoints q = random_motion(random, size, trial % 3 ? size : 100.0 * size);
    // Shifts the first feature so that the chosen points of both features coincide at the meeting
    // time.
    const double s = uniform(random), t = uniform(random) * (face ? 1.0 - s : 1.0);
    const auto at = [&](int i) {
      return Vec3((1.0 - meeting_time) * q[i] + meeting_time * q[4 + i]);
    };
    const Vec3 gap = face ? Vec3(at(0) - (1.0 - s - t) * at(1) - s * at(2) - t * at(3))
                          : Vec3((1.0 - s) * at(0) + s * at(1) - (1.0 - t) * at(2) - t * at(3));
    // The shift is rounded, so the features may miss each other by a rounding error. The test
    // therefore uses a minimum gap above this error.
    for (int i = 0; i < (face ? 1 : 2); ++i) {
      q[i] -= gap;
      q[4 + i] -= gap;
    }
    const Impact impact = test(q, face, 1e-12 * size * 300.0);
    CHECK(impact.hit);
    CHECK(impact.time <= meeting_time + 1e-9);
  }
}

TEST_CASE("the minimum gap of a motion never vanishes") {
  CHECK(gap_floor(1.0, 1e-5) == 1e-5);
  CHECK(gap_floor(2e-5, 1e-5) == 1e-5);
  CHECK(gap_floor(1e-6, 1e-5) == 0.5e-6);
  CHECK(gap_floor(1e-8, 1e-5) == Approx(0.9e-8));
  MovingPoints q = {Vec3(0.2, 0.2, 1e-3), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0),
                    Vec3(0.2, 0.2, -1),   Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const Impact impact = continuous_vertex_face_above_gap(q, 1e-5);
  REQUIRE(impact.hit);
  CHECK(1e-3 - impact.time * 1.001 == Approx(1e-5).epsilon(1e-6));
  q[4] = Vec3(0.2, 0.2, 1.1e-5);
  CHECK_FALSE(continuous_vertex_face_above_gap(q, 1e-5).hit);
}
