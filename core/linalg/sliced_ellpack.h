// Sliced-ELLPACK layout of a block matrix: slices of eight rows, which kernels process at once,
// sorted by row length (Monakov, Lokhmotov and Avetisyan, HiPEAC 2010). Slot s of a slice holds the
// s-th off-diagonal block of each of its rows. Rows are sorted only within blocks of rows_per_block
// rows, which slices do not cross; rows of equal length share a slice, so little padding is needed.
// Rows that follow the matrix (bodies) have a diagonal block alone.
#pragma once

#include <vector>

#include "core/linalg/block_matrix.h"

namespace loomstone {

class SlicedEllpack {
 public:
  // Lays out slices for the rows of the matrix (may be null) and those that follow up to n_rows.
  // Returns false where the layout is that of this pattern already.
  bool set_pattern(const BlockMatrix* matrix, Index n_rows);

  Index n_rows() const { return n_rows_; }
  Index n_slices() const { return static_cast<Index>(slot_start.size()) - 1; }
  // Slices of the rows [begin, end), which are whole blocks of rows_per_block rows (the last may be
  // shorter).
  static Index first_slice(Index begin) { return begin / 8; }
  static Index last_slice(Index end) { return (end + 7) / 8; }

  std::vector<Index> rows;           // (slices x 8) n_rows() where a lane is empty
  std::vector<Index> place;          // (rows) 8 slice + lane
  std::vector<Index> slot_start{0};  // (slices + 1)
  std::vector<Index> columns;        // (slots x 8) the row itself in padding
  std::vector<Index> sources;        // (slots x 8) block of the matrix; -1 in padding

 private:
  bool is_pattern_of(const BlockMatrix* matrix, Index n_rows) const;

  Index n_rows_ = -1, n_coupled_ = 0;
  std::vector<Index> pattern_start_, pattern_columns_;
};

}  // namespace loomstone
