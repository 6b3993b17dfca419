// Tests of exact continuous collision detection: cases solved by hand, properties of exact results,
// and published queries.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <fstream>
#include <random>
#include <string>

#include "core/collision/narrow_phase/exact_continuous.h"
#include "core/collision/narrow_phase/float_continuous.h"
#include "core/collision/narrow_phase/separation.h"

using namespace loomstone;

namespace {

bool meet(const MovingPoints& q, bool face) {
  return face ? exactly_meet_vertex_face(q) : exactly_meet_edge_edge(q);
}
Impact continuous(const MovingPoints& q, bool face) {
  return face ? continuous_vertex_face(q) : continuous_edge_edge(q);
}
ExactImpact exact(const MovingPoints& q, bool face) {
  return face ? exact_continuous_vertex_face(q) : exact_continuous_edge_edge(q);
}

// A vertex moves from height `from` to `to` above the resting triangle (0,0), (1,0), (0,1).
MovingPoints falling(double x, double y, double from, double to) {
  return {Vec3(x, y, from), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0),
          Vec3(x, y, to),   Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
}

// Returns a random motion with small integer coordinates, which is often degenerate.
MovingPoints on_lattice(std::mt19937& random, int largest) {
  std::uniform_int_distribution<int> number(-largest, largest);
  MovingPoints q;
  for (Vec3& point : q) point = Vec3(number(random), number(random), number(random));
  return q;
}

MovingPoints permuted(const MovingPoints& q, const std::array<int, 4>& order) {
  MovingPoints result;
  for (int i = 0; i < 4; ++i) result[i] = q[order[i]], result[4 + i] = q[4 + order[i]];
  return result;
}

}  // namespace

TEST_CASE(
    "a contact at either end of the step counts, and one unit of rounding away from it does not") {
  const double tiny = std::nextafter(0.0, 1.0), one_up = std::nextafter(1.0, 2.0);
  CHECK(meet(falling(0.25, 0.25, 1.0, 0.0), true));
  CHECK_FALSE(meet(falling(0.25, 0.25, 1.0, tiny), true));
  CHECK(meet(falling(0.25, 0.25, 0.0, 1.0), true));
  CHECK_FALSE(meet(falling(0.25, 0.25, tiny, 1.0), true));
  CHECK(meet(falling(0.25, 0.75, 1.0, -1.0), true));  // on an edge
  CHECK_FALSE(meet(falling(0.25, std::nextafter(0.75, 1.0), 1.0, -1.0), true));
  CHECK(meet(falling(1.0, 0.0, 1.0, -1.0), true));  // on a corner
  CHECK_FALSE(meet(falling(one_up, 0.0, 1.0, -1.0), true));
  CHECK_FALSE(meet(falling(-tiny, 0.5, 1.0, -1.0), true));
}

TEST_CASE("motions within one plane, along one line and without motion are decided") {
  // The vertex stays in the plane of the face. In turn, it moves through the face, through a corner
  // and past the face, and it rests inside, on an edge and outside.
  const auto in_plane = [](const Vec3& from, const Vec3& to) {
    MovingPoints q = falling(0, 0, 0, 0);
    q[0] = from, q[4] = to;
    return meet(q, true);
  };
  CHECK(in_plane(Vec3(-1, 0.25, 0), Vec3(2, 0.25, 0)));
  CHECK(in_plane(Vec3(-1, 1, 0), Vec3(2, 1, 0)));
  CHECK_FALSE(in_plane(Vec3(-1, 1.5, 0), Vec3(2, 1.5, 0)));
  CHECK(in_plane(Vec3(0.25, 0.25, 0), Vec3(0.25, 0.25, 0)));
  CHECK(in_plane(Vec3(0.5, 0.5, 0), Vec3(0.5, 0.5, 0)));
  CHECK_FALSE(in_plane(Vec3(0.75, 0.75, 0), Vec3(0.75, 0.75, 0)));
  // Edges on one line stay apart or meet during the motion, and parallel edges pass side by side.
  const auto on_line = [](double shift, double offset) {
    return meet({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, offset, 0), Vec3(3, offset, 0),
                 Vec3(shift, 0, 0), Vec3(1 + shift, 0, 0), Vec3(2, offset, 0), Vec3(3, offset, 0)},
                false);
  };
  CHECK_FALSE(on_line(0.5, 0.0));
  CHECK(on_line(1.0, 0.0));
  CHECK(on_line(5.0, 0.0));
  CHECK_FALSE(on_line(5.0, std::nextafter(0.0, 1.0)));
  // Edges degenerate to points, and a face degenerates to a line.
  const auto points = [](double x) {
    const Vec3 above(0, 0, 1), below(0, 0, -1), other(x, 0, 0);
    return meet({above, above, other, other, below, below, other, other}, false);
  };
  CHECK(points(0.0));
  CHECK_FALSE(points(1.0));
  const auto line_face = [](double x) {
    const Vec3 a(0, 0, 0), b(1, 0, 0), c(2, 0, 0);
    return meet({Vec3(x, 0, 1), a, b, c, Vec3(x, 0, -1), a, b, c}, true);
  };
  CHECK(line_face(1.5));
  CHECK_FALSE(line_face(2.5));
}

TEST_CASE("coordinates of any magnitude are decided") {
  for (const double scale : {1e-300, 1e-40, 1e30, 1e150}) {
    MovingPoints q = falling(0.25, 0.25, 1.0, -1.0);
    for (Vec3& point : q) point *= scale;
    CHECK(meet(q, true));
    CHECK(exact(q, true).hit);
  }
  MovingPoints mixed = falling(0.25, 0.25, 1e30, -1e-40);
  CHECK(meet(mixed, true));
  mixed[4].z() = 1e-40;
  CHECK_FALSE(meet(mixed, true));
}

TEST_CASE(
    "the verdict does not depend on order, direction of time, position or unit, and agrees with "
    "points at rest") {
  std::mt19937 random(5);
  int hits = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const bool face = trial % 2;
    const MovingPoints q = on_lattice(random, 2 + trial % 3);
    const bool verdict = meet(q, face);
    hits += verdict;
    MovingPoints reversed, moved;
    for (int i = 0; i < 8; ++i) {
      reversed[i] = q[(i + 4) % 8];
      moved[i] = 0.125 * (q[i] + Vec3(1024, -3, 77));
    }
    CHECK(meet(reversed, face) == verdict);
    CHECK(meet(moved, face) == verdict);
    CHECK(meet(permuted(q, face ? std::array<int, 4>{0, 2, 3, 1} : std::array<int, 4>{2, 3, 0, 1}),
               face) == verdict);
    CHECK(meet(permuted(q, face ? std::array<int, 4>{0, 2, 1, 3} : std::array<int, 4>{0, 1, 3, 2}),
               face) == verdict);
    CHECK(exact(q, face).hit == verdict);
    // If the motion has no collision, the features are apart at every instant. Nine instants are
    // tested, at eighths of the step. The coordinates are small integers, so the positions at these
    // instants are exact in floating point.
    for (int k = 0; k <= 8 && !verdict; ++k) {
      MovingPoints rest;
      for (int i = 0; i < 4; ++i) rest[i] = rest[4 + i] = ((8 - k) * q[i] + k * q[4 + i]) / 8.0;
      CHECK_FALSE(meet(rest, face));
    }
  }
  CHECK(hits > 500);
  CHECK(hits < 2500);
}

TEST_CASE(
    "contacts at known times and positions, exact in binary, are found, and floating-point proofs "
    "are true") {
  std::mt19937 random(6);
  std::uniform_int_distribution<int> sixteenth(0, 16), number(-1024, 1024);
  for (int trial = 0; trial < 2000; ++trial) {
    const bool face = trial % 2;
    MovingPoints q;
    for (Vec3& point : q)
      point = 16.0 * 16.0 * 16.0 * Vec3(number(random), number(random), number(random));
    const double time = sixteenth(random) / 16.0, s = sixteenth(random) / 16.0;
    const double t = face ? (16.0 - 16.0 * s) / 16.0 * (trial % 5) / 4.0 : sixteenth(random) / 16.0;
    const auto at = [&](int i) { return Vec3((1.0 - time) * q[i] + time * q[4 + i]); };
    const Vec3 gap = face ? Vec3(at(0) - (1.0 - s - t) * at(1) - s * at(2) - t * at(3))
                          : Vec3((1.0 - s) * at(0) + s * at(1) - (1.0 - t) * at(2) - t * at(3));
    for (int i = 0; i < (face ? 1 : 2); ++i) q[i] -= gap, q[4 + i] -= gap;
    CHECK(meet(q, face));
    CHECK(continuous(q, face).hit);
    CHECK(exact(q, face).time <= time);
  }
}

TEST_CASE("floating-point proofs and separating planes agree with integer arithmetic") {
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  int n_meet = 0, n_apart = 0, n_open = 0, n_separated = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const bool face = trial % 2;
    MovingPoints q;
    const double size = trial % 7 == 0 ? 1e-40 : trial % 7 == 1 ? 1e30 : 1.0;
    for (Vec3& point : q)
      point = size * Vec3(normal(random), normal(random),
                          trial % 3 ? normal(random) : 1e-7 * normal(random));
    if (trial % 5 == 0) q = on_lattice(random, 3);
    if (trial % 4 == 0)
      for (int i = 4; i < 8; ++i) q[i] = q[i - 4] + 0.1 * (q[i] - q[i - 4]);
    const bool truth = meet(q, face);
    const Decision decision = face ? decide_vertex_face(q) : decide_edge_edge(q);
    if (decision.proof == Proof::Meet) CHECK(truth);
    if (decision.proof == Proof::Apart) CHECK_FALSE(truth);
    (decision.proof == Proof::Meet    ? n_meet
     : decision.proof == Proof::Apart ? n_apart
                                      : n_open) += 1;
    // The features are apart until the reported time.
    MovingPoints before = q;
    for (int i = 4; i < 8; ++i) before[i] = q[i - 4] + 0.999 * decision.time * (q[i] - q[i - 4]);
    if (decision.time > 0.0 && decision.proof != Proof::Apart && decision.time < 1.0)
      CHECK_FALSE(meet(before, face));
    bool left = false;
    without_separated(
        face, 1, [&](Index, int k) { return q[k].data(); }, [&](Index) { left = true; });
    n_separated += !left;
    if (!left) CHECK_FALSE(truth);
  }
  CHECK(n_meet > 200);
  CHECK(n_apart > 500);
  CHECK(n_open < 1000);
  CHECK(n_separated > 500);
}

// tests/collision/convert_queries.py makes the query files from archives of queries with exact
// verdicts.
namespace {

// Checks all queries of a file. The exact test must never be wrong. The conservative test must miss
// no impact, and may report false impacts for at most the fraction `bound` of the queries. Neither
// test may report an impact later than the upper bound on the first contact time.
// without_separated() must remove no query with an impact.
void check_queries(const std::string& path, double bound) {
  INFO(path);
  std::ifstream file(path, std::ios::binary);
  REQUIRE(file);
  // A row contains 24 coordinates, the kind (0 vertex-face, 1 edge-edge), the verdict, and a lower
  // and an upper bound on the first contact time.
  double row[28];
  long n = 0, missed = 0, false_hits = 0, late = 0, wrong = 0, left = 0, n_left = 0,
       separated_hits = 0;
  while (file.read(reinterpret_cast<char*>(row), sizeof row)) {
    MovingPoints q;
    for (int i = 0; i < 8; ++i) q[i] = Vec3(row[3 * i], row[3 * i + 1], row[3 * i + 2]);
    const bool face = row[24] == 0.0, truth = row[25] != 0.0;
    const Impact impact = continuous(q, face);
    ++n;
    missed += truth && !impact.hit;
    false_hits += !truth && impact.hit;
    late += truth && impact.hit && impact.time > row[27];
    const ExactImpact verdict = exact(q, face);
    wrong += verdict.hit != truth;
    late += truth && verdict.time > row[27];
    without_separated(face, 1, [&](Index, int k) { return q[k].data(); }, [&](Index) { ++left; });
    separated_hits += truth && left == n_left;
    n_left = left;
  }
  INFO(n << " queries, missed " << missed << ", false " << false_hits << ", late " << late
         << ", wrong " << wrong);
  CHECK(n > 0);
  CHECK(missed == 0);
  CHECK(late == 0);
  CHECK(false_hits <= bound * n);
  CHECK(wrong == 0);
  CHECK(separated_hits == 0);
}

}  // namespace

TEST_CASE(
    "published queries: no collision is missed, few free motions are reported as hits, and all "
    "exact verdicts are right") {
  const char* directory = std::getenv("LOOMSTONE_CCD_QUERIES");
  if (!directory) {
    WARN(
        "skipped: LOOMSTONE_CCD_QUERIES names no directory of files made by "
        "tests/collision/convert_queries.py");
    return;
  }
  // Motions of real and synthetic scenes, where a false impact would withhold motion needlessly.
  check_queries(std::string(directory) + "/candidates.bin", 0.01);
  check_queries(std::string(directory) + "/scene_queries.bin", 0.01);
  // In constructed degenerate queries, features without contact can pass each other at a distance
  // below the rounding error. The conservative test reports such a pass as an impact, so the bound
  // is larger than above.
  check_queries(std::string(directory) + "/sample_queries.bin", 0.1);
  check_queries(std::string(directory) + "/degenerate.bin", 0.1);
}
