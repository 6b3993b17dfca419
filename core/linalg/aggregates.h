// Rows of a block matrix in compact aggregates of about a dozen coupled rows, for coarse levels. No
// aggregate leaves its block of rows_per_block rows, so that those of a rank lie in its rows; they
// are numbered block by block.
#pragma once

#include <vector>

#include "core/linalg/block_matrix.h"

namespace loomstone {

struct Aggregates {
  std::vector<Index> of_row;       // (rows)
  std::vector<Index> block_start;  // (blocks of rows + 1) first aggregate of each block
  Index count() const { return block_start.back(); }
};

Aggregates grow_aggregates(const BlockMatrix& matrix);

}  // namespace loomstone
