// Compact aggregates of about a dozen coupled rows of a block matrix, for aggregation multigrid. An
// aggregate lies within one block of rows_per_block rows, so it belongs to one rank. Aggregates are
// numbered block by block.
#pragma once

#include <vector>

#include "core/linalg/block_matrix.h"

namespace loomstone {

struct Aggregates {
  std::vector<Index> of_row;       // (rows) aggregate of each row
  std::vector<Index> block_start;  // (blocks of rows + 1) first aggregate of each block
  Index count() const { return block_start.back(); }
};

Aggregates grow_aggregates(const BlockMatrix& matrix);

}  // namespace loomstone
