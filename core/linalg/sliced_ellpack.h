// Sliced-ELLPACK layout of a block matrix (Monakov, Lokhmotov and Avetisyan, HiPEAC 2010). Rows are
// grouped in slices of eight, which kernels process at once. Slot s of a slice contains the s-th
// off-diagonal block of each of its rows. A row block is a range of rows_per_block rows. Rows are
// sorted by length within each row block, so that slices need little padding. Each slice lies
// within one row block. Rows that follow the matrix (bodies) have only a diagonal block.
#pragma once

#include <vector>

#include "core/linalg/block_matrix.h"

namespace loomstone {

class SlicedEllpack {
 public:
  // Builds the slices for the rows of `matrix`, which may be null, and for the rows that follow
  // them up to n_rows. Returns false if the slices were already built for the same pattern.
  bool set_pattern(const BlockMatrix* matrix, Index n_rows);
  // Builds slices for the rows [begin, end) of `matrix` only. The first slice starts at row
  // `begin`.
  void set_pattern(const BlockMatrix& matrix, Index begin, Index end);

  Index n_rows() const { return n_rows_; }
  Index n_slices() const { return static_cast<Index>(slot_start.size()) - 1; }
  // The rows [begin, end) have the slices [first_slice(begin), last_slice(end)). The rows must form
  // whole row blocks; only the last row block may be shorter.
  static Index first_slice(Index begin) { return begin / 8; }
  static Index last_slice(Index end) { return (end + 7) / 8; }

  std::vector<Index> rows;   // (slices x 8) row of each lane; n_rows() for an empty lane
  std::vector<Index> place;  // (rows) position of each row: 8 slice + lane; -1 without a slice
  std::vector<Index> slot_start{0};  // (slices + 1) first slot of each slice
  std::vector<Index> columns;        // (slots x 8) column of each block; in padding, the row index
  std::vector<Index> sources;        // (slots x 8) block of the matrix; -1 in padding

 private:
  bool is_pattern_of(const BlockMatrix* matrix, Index n_rows) const;
  void build(Index begin, Index end);
  void add_slice(const Index* of_slice);
  Index n_beside(Index row) const {  // number of off-diagonal blocks of a row
    return row < n_coupled_ ? pattern_start_[row + 1] - pattern_start_[row] - 1 : 0;
  }

  Index n_rows_ = -1, n_coupled_ = 0;
  std::vector<Index> pattern_start_, pattern_columns_;
};

}  // namespace loomstone
