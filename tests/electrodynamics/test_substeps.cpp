// Tests of Substeps, which divides a step into sub-steps that resolve the fastest oscillation and
// the relative motion of magnets.
#include <catch2/catch.hpp>

#include <limits>

#include "core/base/error.h"
#include "core/electrodynamics/kick_drift_kick.h"

using namespace loomstone;

namespace {

// Lengths [s] of the first sub-steps of a 1 s step, given the angular frequency [rad/s] at the
// start of each of them.
std::vector<double> lengths(const std::vector<double>& frequencies) {
  Substeps parts(1.0, 0.15);
  std::vector<double> result;
  for (const double frequency : frequencies) {
    REQUIRE(parts.left());
    parts.resolve(frequency);
    result.push_back(parts.length());
    parts.pass();
  }
  return result;
}

}  // namespace

TEST_CASE("a step that resolves its oscillation has one sub-step") {
  Substeps parts(1e-3, 0.15);
  parts.resolve(149.0);
  CHECK(parts.length() == 1e-3);
  parts.pass();
  CHECK(!parts.left());
}

TEST_CASE(
    "sub-steps are repeated halves of the step, resolve the oscillation and add up to the step") {
  Substeps parts(1.0, 0.15);
  double length = 0.0;
  int n = 0;
  for (; parts.left(); ++n) {
    CHECK(parts.elapsed() == length);
    CHECK(parts.share() == length);
    parts.resolve(1.0);
    CHECK(parts.length() * 1.0 <= 0.15);
    length += parts.length();
    parts.pass();
  }
  CHECK(n == 8);
  CHECK(length == 1.0);
}

TEST_CASE("within a step sub-steps are halved once the oscillation has grown by a third") {
  CHECK(lengths({1.2, 1.5}) == std::vector<double>{0.125, 0.125});
  CHECK(lengths({1.2, 1.7}) == std::vector<double>{0.125, 0.0625});
}

TEST_CASE("an oscillation that no sub-step resolves is refused") {
  CHECK_THROWS_AS(lengths({1e4}), SolverFailure);
  CHECK_THROWS_AS(lengths({std::numeric_limits<double>::quiet_NaN()}), SolverFailure);
}

TEST_CASE("halved sub-steps fill the rest of the step, and at most 4096 are taken") {
  Substeps parts(1.0, 0.15);
  parts.resolve(0.3);
  CHECK(parts.length() == 0.5);
  CHECK(parts.next_share() == 0.5);
  parts.pass();
  CHECK(parts.halve());
  CHECK(parts.elapsed() == 0.5);
  CHECK(parts.length() == 0.25);
  CHECK(parts.next_share() == 0.75);
  while (parts.halve()) continue;
  CHECK(parts.length() == 1.0 / 4096.0);
  CHECK(parts.elapsed() == 0.5);
}

TEST_CASE("sub-steps resolve the relative motion of magnets as far as their number permits") {
  Substeps parts(1.0, 0.15);
  parts.follow(0.15);
  CHECK(parts.length() == 1.0);
  parts.follow(1.0);
  CHECK(parts.length() == 0.125);
  CHECK(parts.resolved_motion() == 0.15 / 0.125);
  parts.follow(0.0);
  CHECK(parts.length() == 0.125);
  parts.follow(1e9);
  CHECK(parts.length() == 1.0 / 4096.0);
}
