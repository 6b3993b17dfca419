// Measures the costs of the tests of a search on one thread. pool_replay.h predicts times on many
// ranks from these costs.
#pragma once

#include <functional>
#include <vector>

#include "core/parallel/pool_replay.h"

namespace loomstone {

// Function that returns the tests with which a rank starts.
using FirstTests = std::function<std::vector<NodeTest>(int rank)>;

// Calls `perform` for all tests of a search that `n_ranks` ranks would divide among themselves.
// Writes to `tests` the tree of these tests, their costs, and the time that each rank needs to find
// the tests with which it starts. If `tests` is not empty, it must contain an earlier record of the
// same search. Each cost and time is then the smaller of its old and its new value, to reduce the
// influence of other programs.
void record_tests(const FirstTests& first_tests, int n_ranks, const TaskPool::Perform& perform,
                  RecordedTests& tests);

}  // namespace loomstone
