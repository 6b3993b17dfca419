#include <catch2/catch.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

#include "core/parallel/task_pool.h"
#include "core/parallel/traverse.h"
#include "tests/parallel/random_tree.h"
#include "tests/parallel/threads_as_ranks.h"

using namespace loomstone;
using testing::on_ranks;
using testing::RandomTree;
using testing::ThreadMailboxes;

namespace {

using Visits = std::vector<std::atomic<int>>;

bool each_once(const Visits& visits) {
  return std::all_of(visits.begin(), visits.end(), [](int n) { return n == 1; });
}

// Runs `rounds` rounds of the pool on threads that act as ranks, and checks that every test of a
// round is performed once. Successive rounds have different trees. Returns one report per rank,
// with numbers of tests and messages summed over the rounds.
std::vector<PoolReport> run_rounds(int n_ranks, int threads, int rounds, unsigned seed) {
  ThreadMailboxes mailboxes(n_ranks, 20e-6, seed);
  std::vector<RandomTree> trees;
  for (unsigned i = 0; i < 16; ++i) trees.emplace_back(1 + i % 5, 1 + 37 * i, seed + i);
  std::vector<Visits> visits(rounds);
  for (int round = 0; round < rounds; ++round) visits[round] = Visits(trees[round % 16].size());
  std::vector<PoolReport> sums(n_ranks);
  std::atomic<int> broken{0};
  on_ranks(n_ranks, [&](int rank) {
    TaskPool pool(mailboxes[rank]);
    for (int round = 0; round < rounds; ++round) {
      const RandomTree& tree = trees[round % 16];
      const PoolReport report =
          pool.run(Team{threads}, tree.roots(rank, n_ranks),
                   [&](int, const NodeTest& test, std::vector<NodeTest>& stack) {
                     broken += !RandomTree::intact(test);
                     ++visits[round][tree.expand(test, stack)];
                   });
      sums[rank].tests += report.tests;
      sums[rank].requests += report.requests;
      sums[rank].transfers += report.transfers;
      sums[rank].refusals += report.refusals;
      sums[rank].received += report.received;
    }
  });
  CHECK(broken == 0);
  for (int round = 0; round < rounds; ++round)
    if (!each_once(visits[round])) FAIL("round " << round << " lost or repeated a test");
  return sums;
}

}  // namespace

TEST_CASE("ranks whose messages are late and out of order perform every test once") {
  for (const int n_ranks : {1, 2, 3, 5}) {
    const std::vector<PoolReport> reports = run_rounds(n_ranks, 1, 60, 7 * n_ranks);
    std::int64_t sent = 0, received = 0;
    for (const PoolReport& report : reports) sent += report.transfers, received += report.received;
    CHECK(sent == received);
    if (n_ranks == 1) CHECK(sent == 0);
  }
}

TEST_CASE("a rank without work receives tasks while another rank has work") {
  for (const int n_ranks : {2, 3, 5}) {
    ThreadMailboxes mailboxes(n_ranks, 20e-6, n_ranks);
    const RandomTree tree(1, 20000, 4);
    std::vector<std::atomic<int>> performed(n_ranks);
    std::vector<PoolReport> reports(n_ranks);
    on_ranks(n_ranks, [&](int rank) {
      TaskPool pool(mailboxes[rank]);
      const auto all_work = [&] {
        return std::all_of(performed.begin(), performed.end(), [](const auto& n) { return n > 0; });
      };
      const auto perform = [&](int, const NodeTest& test, std::vector<NodeTest>& stack) {
        ++performed[rank];
        tree.expand(test, stack);
        if (!all_work()) std::this_thread::sleep_for(std::chrono::microseconds(50));
      };
      // Rank 0 starts with the root of the tree, and the other ranks start with no test.
      reports[rank] =
          pool.run(Team{1}, rank == 0 ? tree.roots(0, 1) : std::vector<NodeTest>(), perform);
    });
    CHECK(reports[0].transfers > 0);
    for (int rank = 1; rank < n_ranks; ++rank) {
      CHECK(reports[rank].received > 0);
      CHECK(reports[rank].tests > 0);
    }
  }
}

TEST_CASE("ranks of several threads perform every test once") { run_rounds(2, 2, 20, 3); }

TEST_CASE("more ranks than messages can pass directly still end together") {
  // The tree of 40 ranks along which the end is detected has three levels, rank 0 included.
  run_rounds(40, 1, 3, 11);
}

TEST_CASE("pools hold for the number of rounds in POOL_ROUNDS", "[.rounds]") {
  const char* const rounds = std::getenv("POOL_ROUNDS");
  run_rounds(4, 1, rounds ? std::atoi(rounds) : 10000, 5);
}

TEST_CASE("an error in a test is thrown on its rank when all ranks have finished") {
  ThreadMailboxes mailboxes(3, 20e-6, 1);
  const RandomTree tree(6, 500, 2);
  std::atomic<int> thrown{0}, finished{0};
  on_ranks(3, [&](int rank) {
    TaskPool pool(mailboxes[rank]);
    const auto perform = [&](int, const NodeTest& test, std::vector<NodeTest>& stack) {
      if (tree.expand(test, stack) == 100) throw std::runtime_error("node 100");
    };
    try {
      pool.run(Team{1}, tree.roots(rank, 3), perform);
      ++finished;
    } catch (const std::runtime_error& error) {
      thrown += std::string(error.what()) == "node 100";
    }
  });
  CHECK(thrown + finished == 3);
  CHECK(thrown == 1);
}

TEST_CASE("tasks are made from stacks above the threshold only") {
  CHECK(stack_threshold({}, 0) == 8);
  CHECK(stack_threshold({}, 5) == 18);
  ThreadMailboxes mailboxes(2, 0.0, 1);
  std::vector<std::int64_t> created(2);
  on_ranks(2, [&](int rank) {
    TaskPool pool(mailboxes[rank]);
    const std::vector<NodeTest> roots(rank == 0 ? 8 : 0);
    created[rank] = pool.run(Team{1}, roots, [](int, const NodeTest&, auto&) {}).created;
  });
  CHECK(created[0] + created[1] == 0);
}

TEST_CASE("a traversal visits every entry once on any number of threads") {
  const RandomTree tree(9, 20000, 4);
  for (const int threads : {1, 2, 5}) {
    Visits visits(tree.size());
    std::atomic<bool> numbered{true};
    parallel_traverse(Team{threads}, tree.roots(0, 1),
                      [&](int thread, const NodeTest& test, std::vector<NodeTest>& stack) {
                        if (thread < 0 || thread >= threads) numbered = false;
                        ++visits[tree.expand(test, stack)];
                      });
    CHECK(each_once(visits));
    CHECK(numbered);
  }
}

TEST_CASE("an error in a traversal is rethrown after it") {
  for (const int threads : {1, 3})
    CHECK_THROWS_WITH(
        parallel_traverse(Team{threads}, std::vector<int>(50, 1),
                          [](int, int, std::vector<int>&) { throw std::runtime_error("entry"); }),
        "entry");
}
