// Tests of the times for which ranks compute and wait in a step.
#include <catch2/catch.hpp>

#include <thread>

#include "core/sim/step/step_outcome.h"
#include "tests/parallel/thread_communicator.h"

using namespace loomstone;

TEST_CASE("computing and waiting of a step add up to its wall time") {
  const RankWork work[2] = {{4.0, 1.5, 0.5, {1.0, 100, 7}}, {3.0, 0.5, 0.25, {2.5, 300, 7}}};
  loomstone::testing::ThreadCommunicators ranks(2, 0.0, 1);
  RankReport reports[2];
  std::thread other([&] { reports[1] = summary_of(*ranks[1], work[1]); });
  reports[0] = summary_of(*ranks[0], work[0]);
  other.join();
  for (const RankReport& report : reports) {
    CHECK(report.computing == 0.5 * (3.0 + 0.5));
    CHECK(report.waiting == 0.5 * (1.0 + 2.5));
    CHECK(report.computing + report.waiting == 0.5 * (4.0 + 3.0));
    CHECK(report.most_computing == 3.0);
    CHECK(report.most_waiting == 2.5);
    CHECK(report.collision_computing == 1.0);
    CHECK(report.collision_waiting == 0.375);
    CHECK(report.bytes == 200);
    CHECK(report.operations == 7);
  }
}

TEST_CASE("a single rank computes all the time") {
  const RankReport report = summary_of(*single_communicator(), {2.0, 1.0, 0.0, {}});
  CHECK(report.computing == 2.0);
  CHECK(report.waiting == 0.0);
  CHECK(report.operations == 0);
}
