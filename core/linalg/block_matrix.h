// Sparse matrix of 3x3 blocks in compressed row storage. The pattern is fixed, symmetric and
// contains the diagonal. Columns are in ascending order. If a matrix stores only a range of its
// rows, such as those that a rank owns, the other rows have no blocks.
#pragma once

#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

class BlockMatrix {
 public:
  BlockMatrix() = default;
  // Builds the pattern from pairs (i, j) with i != j, in any order and with possible duplicates.
  // Adds the transposed pairs and the diagonal.
  BlockMatrix(Index n_rows, const std::vector<std::pair<Index, Index>>& couplings)
      : BlockMatrix(n_rows, couplings, 0, n_rows) {}
  // Stores only the rows [begin, end). Pairs without such a row are ignored.
  BlockMatrix(Index n_rows, const std::vector<std::pair<Index, Index>>& couplings, Index begin,
              Index end);

  Index n_rows() const { return static_cast<Index>(diagonal_.size()); }
  Index n_blocks() const { return static_cast<Index>(columns_.size()); }
  const std::vector<Index>& row_start() const { return row_start_; }  // (n_rows + 1)
  const std::vector<Index>& columns() const { return columns_; }      // (n_blocks)
  // (n_rows) Index of the diagonal block of each row; -1 if the row is not stored.
  const std::vector<Index>& diagonal() const { return diagonal_; }
  // Returns the index of block (row, column), or -1 if the pattern does not contain it.
  Index find(Index row, Index column) const;

  // Returns the 9 entries of a block in column-major order.
  double* block(Index position) { return values_.data() + 9 * static_cast<std::size_t>(position); }
  const double* block(Index position) const {
    return values_.data() + 9 * static_cast<std::size_t>(position);
  }
  Eigen::Map<Mat3> block_map(Index position) { return Eigen::Map<Mat3>(block(position)); }
  Eigen::Map<const Mat3> block_map(Index position) const {
    return Eigen::Map<const Mat3>(block(position));
  }
  void set_zero();
  std::size_t bytes() const { return bytes_of(row_start_, columns_, diagonal_, values_); }

  // Computes y = A x on rows [begin, end). x has all rows, and y only the rows [begin, end). y has
  // 4 doubles per row, the fourth of which is zero; x has `stride` doubles per row, 3 or 4.
  void multiply(Index begin, Index end, const double* x, double* y, int stride = 4) const;

 private:
  std::vector<Index> row_start_{0}, columns_, diagonal_;
  // 9 entries per block, then three entries of padding that keep 4-wide loads of columns inside the
  // array.
  std::vector<double> values_;
};

}  // namespace loomstone
