// Task pools that balance the traversal of trees between ranks while it runs ([Thomaszewski2010],
// 5.3). A task consists of tests. A test is a pair of nodes of two hierarchies, given by four
// indices, so that any rank can perform it. Each worker thread performs tests depth first with its
// own stack. If a stack exceeds tau = a sigma + b tests, where sigma is the number of tasks in the
// pool of the rank, tau / 2 tests from the bottom of the stack become a new task (unless there is
// only one thread on one rank). A rank with an empty pool and an idle thread asks the other ranks
// in turn for a task. A rank that is performing no test does not give away its last task. The run
// ends when Termination has found that no rank has work.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/mailbox.h"
#include "core/parallel/team.h"

namespace loomstone {

// Kinds of messages between the ranks of a pool. Request: asks for a task. Refusal and Task:
// answers to a request. Wave, Counts and End: detection of termination (termination.h).
enum class PoolMessage : std::int32_t { Request, Refusal, Task, Wave, Counts, End };

struct NodeTest {
  Index hierarchy_a, hierarchy_b, node_a, node_b;
};

struct PoolOptions {
  Index growth = 2, least = 8;  // a and b of the threshold tau = a sigma + b
  double poll_interval = 5e-6;  // least time between two polls while worker 0 performs tests [s]
};

// Returns how many tests a stack may hold while the pool has `n_tasks` tasks.
inline Index stack_threshold(const PoolOptions& options, Index n_tasks) {
  return options.growth * n_tasks + options.least;
}

// Work of one rank in a run of the pool.
struct PoolReport {
  std::int64_t tests = 0;      // tests performed
  std::int64_t created = 0;    // tasks created from stacks
  std::int64_t requests = 0;   // requests sent
  std::int64_t transfers = 0;  // tasks sent to other ranks
  std::int64_t refusals = 0;   // refused requests of other ranks
  std::int64_t received = 0;   // tasks received from other ranks
  std::int64_t waves = 0;      // waves of the termination detection
  double busy = 0.0;           // time spent on tasks, summed over threads [s]
  double wall = 0.0;           // time from the start to the end [s]
};

class TaskPool {
 public:
  // Performs a test and appends the tests that follow from it to `stack`. Called concurrently by
  // workers 0 to threads - 1.
  using Perform =
      std::function<void(int worker, const NodeTest& test, std::vector<NodeTest>& stack)>;

  explicit TaskPool(Mailbox& mailbox, const PoolOptions& options = {});

  // Collective. Performs the tests that each rank starts with, and all tests that follow from them,
  // each on one rank. Returns when no rank has work. If perform() throws, this rank discards its
  // tests and those that it receives, takes part until the end, and then rethrows the first
  // exception.
  PoolReport run(const Team& team, std::vector<NodeTest> tests, const Perform& perform);

 private:
  Mailbox& mailbox_;
  PoolOptions options_;
  std::int32_t round_ = 0;                     // number of the current run, part of every message
  std::vector<std::vector<std::byte>> early_;  // messages of ranks that are one run ahead
};

}  // namespace loomstone
