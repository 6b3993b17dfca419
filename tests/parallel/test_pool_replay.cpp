#include <catch2/catch.hpp>

#include <random>

#include "core/parallel/pool_replay.h"

using namespace loomstone;

namespace {

// Balanced trees of tests of 1 us each: `n_trees` trees with `depth` levels below the root, and
// four children at each inner node. Rank 0 starts with all trees.
RecordedTests trees_on_rank_0(int n_trees, int depth, int n_ranks) {
  RecordedTests tests;
  tests.roots.resize(n_ranks);
  tests.start.assign(n_ranks, 0.0);
  Index n = n_trees;
  for (Index i = 0; i < n_trees; ++i) tests.roots[0].push_back(i);
  Index level = n_trees;
  for (int d = 0; d <= depth; ++d, level *= 4)
    for (Index i = 0; i < level; ++i) {
      tests.first_child.push_back(n);
      tests.n_children.push_back(d < depth ? 4 : 0);
      tests.seconds.push_back(1e-6);
      n += d < depth ? 4 : 0;
    }
  return tests;
}

}  // namespace

TEST_CASE("a replay on one rank takes the time of all tests") {
  const RecordedTests tests = trees_on_rank_0(3, 5, 1);
  CHECK(tests.work() == Approx(1e-6 * static_cast<double>(tests.size())));
  CHECK(replay_static(tests, {}).seconds == Approx(tests.work()));
  CHECK(replay_dynamic(tests, {}).seconds == Approx(tests.work()));
}

TEST_CASE("a static replay takes the time of the slowest rank and of the exchange") {
  RecordedTests tests = trees_on_rank_0(1, 4, 4);
  tests.result_bytes = 1000;
  const Network network{2e-6, 1e8, 0.5e-6};
  // The exchange takes two rounds among four ranks. A round takes 2 us + 2 x 0.5 us, and 1000 B
  // take 10 us at 1e8 B/s.
  CHECK(replay_static(tests, network).seconds == Approx(tests.work() + 6e-6 + 1e-5));
  CHECK(replay_static(tests, network).exchange == Approx(16e-6));
  CHECK(replay_static(tests, network).least_busy == 0.0);
}

TEST_CASE("a dynamic replay performs all tests and spreads them over the ranks") {
  const RecordedTests tests = trees_on_rank_0(1, 8, 12);  // 87,381 tests
  const ReplayReport fast = replay_dynamic(tests, {1e-6, 1e10, 0.1e-6});
  CHECK(12 * fast.mean_busy == Approx(tests.work()));
  CHECK(fast.transfers > 12);
  // At the end, one request of each rank may remain without an answer.
  CHECK(fast.requests >= fast.transfers + fast.refusals);
  CHECK(fast.requests <= fast.transfers + fast.refusals + 12);
  // Twelve ranks need at least 7.28 ms for 87.4 ms of work. Balancing adds less than 20 %.
  CHECK(fast.seconds > tests.work() / 12);
  CHECK(fast.seconds < 1.2 * tests.work() / 12);
  const ReplayReport slow = replay_dynamic(tests, {100e-6, 1e10, 0.1e-6});
  CHECK(slow.seconds > 1.1 * fast.seconds);
}

TEST_CASE("a rank performs tests of a task before it passes the task on") {
  // Random costs and latencies make some requests arrive together with tasks.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> cost(0.0, 1e-6), latency(0.5e-6, 2e-6);
  for (int i = 0; i < 300; ++i) {
    RecordedTests tests = trees_on_rank_0(1, 5, 2);  // 1,365 tests
    for (double& seconds : tests.seconds) seconds = cost(random);
    const ReplayReport report = replay_dynamic(tests, {latency(random), 1e10, 0.2e-6});
    CHECK(report.transfers <= static_cast<std::int64_t>(tests.size()));
  }
}

TEST_CASE("a predicted replay takes the time of the most expensive range and of one exchange") {
  // Sixteen pieces of work, of which the last four take twice as long as expected.
  OrderedWork work{
      std::vector<float>(16, 1.0f), std::vector<double>(16, 1e-6), {0, 16}, 4e-6, 1000};
  for (int i = 12; i < 16; ++i) work.seconds[i] = 2e-6;
  CHECK(work.work() == Approx(24e-6));
  const Network network{2e-6, 1e8, 0.5e-6};
  const ReplayReport report = replay_predicted(work, 4, network);
  CHECK(report.least_busy == Approx(5e-6));
  CHECK(report.most_busy == Approx(9e-6));
  // The exchange takes two rounds of 3 us each among four ranks, and 1000 B take 10 us at 1e8 B/s.
  CHECK(report.exchange == Approx(16e-6));
  CHECK(report.seconds == Approx(25e-6));
  CHECK(replay_predicted(work, 1, network).seconds == Approx(work.work()));
}

TEST_CASE("a dynamic replay takes the time in which ranks exchange costs of tests") {
  RecordedTests tests = trees_on_rank_0(1, 4, 4);
  const Network network{2e-6, 1e8, 0.5e-6};
  const double without = replay_dynamic(tests, network).seconds;
  tests.deal_exchanges = 0.25, tests.deal_bytes = 500.0;
  // An exchange of costs takes two rounds of 3 us each. With 0.25 exchanges per search, this adds
  // 1.5 us. The 500 B that each rank receives per search add 5 us at 1e8 B/s.
  CHECK(replay_dynamic(tests, network).seconds == Approx(without + 6.5e-6));
}

TEST_CASE("a rank that starts alone and one that has nothing to give both end") {
  const RecordedTests tests = trees_on_rank_0(1, 0, 300);
  const Network network{10e-6, 1e10, 0.1e-6};
  const ReplayReport report = replay_dynamic(tests, network);
  CHECK(report.transfers == 0);
  CHECK(report.waves >= 2);
  // The tree of ranks, along which the end is detected, has three levels below rank 0, so each of
  // the two waves takes six messages in sequence: three up and three down. The exchange of results
  // has nine rounds. Each message or round takes the latency and some processor time.
  CHECK(report.seconds > (12 + 9) * network.latency);
  CHECK(report.seconds < 2 * (12 + 9) * network.latency);
}
