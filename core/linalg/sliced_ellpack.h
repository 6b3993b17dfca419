// Sliced-ELLPACK layout of a block matrix (Monakov, Lokhmotov and Avetisyan, HiPEAC 2010). Rows are
// grouped in slices of eight, which kernels process at once. Slot s of a slice contains the s-th
// off-diagonal block of each row of the slice (AggregationMultigrid uses the word "slot" for
// something else). Within each row block (a range of rows_per_block rows), rows are sorted by their
// number of off-diagonal blocks, so that slices need little padding. Each slice lies within one row
// block. Rows that follow the matrix (bodies) have only a diagonal block. The layout contains a
// range of the rows, such as those that a rank owns.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/linalg/block_matrix.h"

namespace loomstone {

class SlicedEllpack {
 public:
  // Range [begin, end) of the rows. n_rows is the number of all rows: those of the matrix and those
  // that follow it.
  struct Range {
    Index n_rows, begin, end;
  };
  // Builds the slices for a range of rows. Without a matrix (null), rows have no off-diagonal
  // blocks. Returns false if the slices were already built for the same pattern and range.
  bool set_pattern(const BlockMatrix* matrix, Range range);

  Index n_rows() const { return range_.n_rows; }  // including rows outside the range
  Index n_slices() const { return static_cast<Index>(slot_start.size()) - 1; }
  // The rows [begin, end) of the range have the slices [first_slice(begin), last_slice(end)). The
  // rows must form whole row blocks; only the last row block may be shorter.
  Index first_slice(Index begin) const { return (begin - range_.begin) / 8; }
  Index last_slice(Index end) const { return (end - range_.begin + 7) / 8; }
  std::size_t bytes() const {
    return bytes_of(rows, place, slot_start, columns, sources, pattern_start_, pattern_columns_);
  }

  std::vector<Index> rows;   // (slices x 8) row of each lane; n_rows() for an empty lane
  std::vector<Index> place;  // (rows) position of each row: 8 slice + lane; -1 outside the range
  std::vector<Index> slot_start{0};  // (slices + 1) first slot of each slice
  std::vector<Index> columns;        // (slots x 8) column of each block; in padding, the row index
  std::vector<Index> sources;        // (slots x 8) block of the matrix; -1 in padding

 private:
  bool is_pattern_of(const BlockMatrix* matrix, Range range) const;
  void add_slice(const Index* of_slice);
  Index n_beside(Index row) const {  // number of off-diagonal blocks of a row
    return row < n_coupled_ ? pattern_start_[row + 1] - pattern_start_[row] - 1 : 0;
  }

  Range range_{-1, 0, 0};
  Index n_coupled_ = 0;
  std::vector<Index> pattern_start_, pattern_columns_;
};

}  // namespace loomstone
