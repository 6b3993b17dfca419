// Measures the costs of the tests of a search on one thread. pool_replay.h predicts times on many
// ranks from these costs.
#pragma once

#include <functional>
#include <vector>

#include "core/parallel/pool_replay.h"

namespace loomstone {

// Function that returns the tests with which a rank starts.
using FirstTests = std::function<std::vector<NodeTest>(int rank)>;

// Performs all tests of a search for `n_ranks` ranks, and writes their tree and costs to `tests`.
// If `tests` already contains the same tree, keeps the smaller cost of each test. This reduces the
// influence of other programs on the measurement.
void record_tests(const FirstTests& first_tests, int n_ranks, const TaskPool::Perform& perform,
                  RecordedTests& tests);

}  // namespace loomstone
