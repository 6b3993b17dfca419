// Order of vertices from graph bisection: any contiguous range of rows is a compact patch with a
// short boundary.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Graph in compressed rows: neighbours of vertex i are adjacent[start[i] .. start[i+1]).
struct Graph {
  std::vector<Index> start;
  std::vector<Index> adjacent;
};

// Permutation: entry i is the old index of the vertex that comes i-th. Recursive bisection by METIS
// down to about `rows_per_block` vertices, breadth-first inside a part. Deterministic; independent
// of threads and ranks.
std::vector<Index> bisection_order(const Graph& graph);

}  // namespace loomstone
