// Sparse matrix of 3x3 blocks in compressed rows with a fixed, symmetric pattern (columns
// ascending, diagonal present).
#pragma once

#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

class BlockMatrix {
 public:
  BlockMatrix() = default;
  // Pattern from pairs (i, j), i != j, in any order, repeated or not; made symmetric; diagonal
  // added.
  BlockMatrix(Index n_rows, const std::vector<std::pair<Index, Index>>& couplings);

  Index n_rows() const { return static_cast<Index>(diagonal_.size()); }
  Index n_blocks() const { return static_cast<Index>(columns_.size()); }
  const std::vector<Index>& row_start() const { return row_start_; }  // (n_rows + 1)
  const std::vector<Index>& columns() const { return columns_; }      // (n_blocks)
  const std::vector<Index>& diagonal() const {
    return diagonal_;
  }  // (n_rows) position of the diagonal block
  // Position of block (i, j); -1 where the pattern has none.
  Index find(Index row, Index column) const;

  // The 9 entries of a block, column-major.
  double* block(Index position) { return values_.data() + 9 * static_cast<std::size_t>(position); }
  const double* block(Index position) const {
    return values_.data() + 9 * static_cast<std::size_t>(position);
  }
  Eigen::Map<Mat3> block_map(Index position) { return Eigen::Map<Mat3>(block(position)); }
  Eigen::Map<const Mat3> block_map(Index position) const {
    return Eigen::Map<const Mat3>(block(position));
  }
  void set_zero();

  // y = A x on rows [begin, end); vectors have 4 doubles a row, the fourth is zero.
  void multiply(Index begin, Index end, const double* x, double* y) const;

 private:
  std::vector<Index> row_start_{0}, columns_, diagonal_;
  std::vector<double>
      values_;  // 9 a block, 3 more at the end so that a column may be loaded 4 wide
};

}  // namespace loomstone
