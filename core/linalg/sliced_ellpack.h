// The rows of a block matrix, and rows beside it that have a diagonal block alone, in slices of
// eight, which kernels work at once, and the blocks of each slice in slots: slot s of a slice holds
// the s-th block beside the diagonal of each of its rows. Groups lie within blocks of
// rows_per_block rows, rows with equally many blocks beside one another, so that few places of
// slots stay empty.
#pragma once

#include <vector>

#include "core/linalg/block_matrix.h"

namespace loomstone {

class SlicedEllpack {
 public:
  // Lays the slices out for the rows of the matrix (may be null) and those that follow up to
  // n_rows, unless they are those of this pattern already; returns whether it did.
  bool set_pattern(const BlockMatrix* matrix, Index n_rows);

  Index n_rows() const { return n_rows_; }
  Index n_slices() const { return static_cast<Index>(slot_start.size()) - 1; }
  // Groups of the rows [begin, end), which are whole blocks of rows_per_block rows (the last may be
  // shorter).
  static Index first_slice(Index begin) { return begin / 8; }
  static Index last_slice(Index end) { return (end + 7) / 8; }

  std::vector<Index> rows;           // (slices x 8) n_rows() where a lane is empty
  std::vector<Index> place;          // (rows) 8 slice + lane
  std::vector<Index> slot_start{0};  // (slices + 1)
  std::vector<Index> columns;        // (slots x 8) the row itself where a place is empty
  std::vector<Index> sources;        // (slots x 8) block of the matrix; -1 where a place is empty

 private:
  bool is_pattern_of(const BlockMatrix* matrix, Index n_rows) const;

  Index n_rows_ = -1, n_coupled_ = 0;
  std::vector<Index> pattern_start_, pattern_columns_;
};

}  // namespace loomstone
