// Compact aggregates of about a dozen coupled rows of a block matrix, for aggregation multigrid. An
// aggregate lies within one block of rows_per_block rows, so it belongs to one rank. Aggregates are
// numbered block by block.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/linalg/block_matrix.h"
#include "core/parallel/row_layout.h"

namespace loomstone {

struct Aggregates {
  std::vector<Index> of_row;       // (rows) aggregate of each row
  std::vector<Index> block_start;  // (blocks of rows + 1) first aggregate of each block
  Index count() const { return block_start.back(); }
  std::size_t bytes() const { return bytes_of(of_row, block_start); }
};

// Returns the aggregates of all rows. Each rank grows the aggregates of its own rows, and receives
// the aggregates of the other ranks. Collective.
Aggregates grow_aggregates(const BlockMatrix& matrix, const RowLayout& layout);

}  // namespace loomstone
