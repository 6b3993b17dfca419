// Measures the costs of the tests of a search on one thread, for a replay on any number of ranks.
#pragma once

#include "core/collision/broad_phase/partition_trees.h"
#include "core/parallel/pool_replay.h"

namespace loomstone {

// Performs all tests of a search for `n_ranks` ranks, and writes their tree and costs to `tests`.
// If `tests` already holds the same tree, each cost becomes the smaller of the two, so that times
// in which the processor ran other programs do not count.
void record_tests(const PartitionTrees& trees, int n_ranks, const TaskPool::Perform& perform,
                  RecordedTests& tests);

}  // namespace loomstone
