// Predicts how long a search or other work would take if it were divided among several ranks. The
// costs of its parts must have been recorded before. There is a function for each way to divide the
// work: replay_static(), replay_predicted() (by expected costs) and replay_dynamic() (by task
// pools). Task pools are replayed by a discrete-event simulation, which includes the latency and
// bandwidth of messages, the processor time for each message, and the interval at which ranks poll.
#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel/section_ranges.h"
#include "core/parallel/task_pool.h"

namespace loomstone {

// Tests of one search (a traversal of trees, task_pool.h) and their costs. The tests that follow
// from test i are numbered first_child[i] to first_child[i] + n_children[i] - 1.
struct RecordedTests {
  std::vector<Index> first_child, n_children;
  std::vector<double> seconds;            // cost of each test [s]
  std::vector<std::vector<Index>> roots;  // tests with which each rank starts
  std::vector<double> start;              // time that each rank needs to find its first tests [s]
  std::size_t result_bytes = 0;           // size of all results, which all ranks receive [bytes]
  // After some searches, ranks exchange measured costs, by which they divide the first tests of
  // later searches. deal_exchanges is the mean number of such exchanges per search, and deal_bytes
  // the mean size of the cost data that each rank receives per search [bytes].
  double deal_exchanges = 0.0, deal_bytes = 0.0;

  std::size_t size() const { return seconds.size(); }
  int n_ranks() const { return static_cast<int>(roots.size()); }
  double work() const;  // sum of all costs [s]
};

struct Network {
  double latency = 1.5e-6;   // [s]
  double bandwidth = 1e10;   // [bytes/s]
  double overhead = 0.2e-6;  // processor time to send or receive a message, or to poll [s]
};

struct ReplayReport {
  double seconds = 0.0;   // time until all ranks have all results [s]
  double exchange = 0.0;  // part of `seconds` in which the ranks exchange results and costs [s]
  // Least, mean and largest time that a rank works [s]. Excludes the time to find its first tests
  // and the time for messages.
  double least_busy = 0.0, mean_busy = 0.0, most_busy = 0.0;
  // Numbers of requests, transfers and refusals of all ranks, and number of waves of Termination.
  std::int64_t requests = 0, transfers = 0, refusals = 0, waves = 0;
};

// Pieces of work in a fixed order, grouped into sections. section_ranges() divides them into ranges
// for the ranks, according to the expected costs.
struct OrderedWork {
  std::vector<float> expected;   // expected cost of each piece, in any unit
  std::vector<double> seconds;   // cost of each piece [s]
  SectionStarts first;           // (sections + 1) first piece of each section, then the piece count
  double divisible = 0.0;        // cost of further work, divided evenly among ranks [s]
  std::size_t result_bytes = 0;  // size of all results, which all ranks receive [bytes]

  double work() const;  // sum of all costs [s]
};

// Returns the shortest measured duration of one reading of the clock [s].
double clock_seconds();

// Replays a static division: each rank performs its first tests and all that follow from them.
ReplayReport replay_static(const RecordedTests& tests, const Network& network);
// Replays a dynamic division: the ranks, each with one thread, balance the tests as TaskPool does.
ReplayReport replay_dynamic(const RecordedTests& tests, const Network& network,
                            const PoolOptions& options = {});
// Replays a division by expected costs: each rank performs its ranges of work and an equal part of
// the divisible work, and all ranks then exchange results. The model has no other communication.
ReplayReport replay_predicted(const OrderedWork& work, int n_ranks, const Network& network);

}  // namespace loomstone
