// Measures the costs of the tests of a search on one thread. From these costs, pool_replay.h
// predicts times on many ranks.
#pragma once

#include "core/collision/broad_phase/partition_trees.h"
#include "core/parallel/pool_replay.h"

namespace loomstone {

// Performs all tests of a search for `n_ranks` ranks, and writes their tree and costs to `tests`.
// If `tests` already contains the same tree, keeps the smaller cost of each test. This excludes
// times in which the processor ran other programs.
void record_tests(const PartitionTrees& trees, int n_ranks, const TaskPool::Perform& perform,
                  RecordedTests& tests);

}  // namespace loomstone
