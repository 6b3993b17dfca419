// Orders vertices by graph bisection, so that contiguous ranges of the new order are compact
// patches with short boundaries.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Graph in compressed sparse row (CSR) format. The neighbours of vertex i are the entries start[i]
// to start[i + 1] - 1 of `adjacent`.
struct Graph {
  std::vector<Index> start;
  std::vector<Index> adjacent;
};

// Returns a permutation: entry i is the old index of the vertex with new index i. METIS bisects
// recursively until each part has at most `rows_per_block` vertices, and each part is ordered
// breadth-first. The result is deterministic and does not depend on the numbers of threads and
// ranks.
std::vector<Index> bisection_order(const Graph& graph);

}  // namespace loomstone
