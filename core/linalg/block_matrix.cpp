#include "core/linalg/block_matrix.h"

#include <algorithm>
#include <cassert>

#include "core/linalg/quad.h"

namespace loomstone {

BlockMatrix::BlockMatrix(Index n_rows, const std::vector<std::pair<Index, Index>>& couplings,
                         Index begin, Index end) {
  // Lists the diagonal blocks and each coupling in both directions, then sorts each row and removes
  // duplicates.
  const auto stored = [&](Index row) { return row >= begin && row < end; };
  std::vector<Index> start(n_rows + 1, 0);
  for (Index row = begin; row < end; ++row) ++start[row + 1];
  for (const auto& [i, j] : couplings) {
    assert(i >= 0 && j >= 0 && i < n_rows && j < n_rows && i != j &&
           "couplings join two different rows");
    if (stored(i)) ++start[i + 1];
    if (stored(j)) ++start[j + 1];
  }
  for (Index row = 0; row < n_rows; ++row) start[row + 1] += start[row];
  std::vector<Index> all(start.back()), next(start.begin(), start.end() - 1);
  for (Index row = begin; row < end; ++row) all[next[row]++] = row;
  for (const auto& [i, j] : couplings) {
    if (stored(i)) all[next[i]++] = j;
    if (stored(j)) all[next[j]++] = i;
  }

  row_start_.assign(1, 0);
  row_start_.reserve(n_rows + 1);
  columns_.reserve(all.size());
  diagonal_.resize(n_rows);
  for (Index row = 0; row < n_rows; ++row) {
    const auto first = all.begin() + start[row];
    std::sort(first, all.begin() + start[row + 1]);
    columns_.insert(columns_.end(), first, std::unique(first, all.begin() + start[row + 1]));
    row_start_.push_back(static_cast<Index>(columns_.size()));
    diagonal_[row] = find(row, row);
  }
  columns_.shrink_to_fit();
  values_.assign(9 * columns_.size() + 3, 0.0);
}

Index BlockMatrix::find(Index row, Index column) const {
  const auto begin = columns_.begin() + row_start_[row],
             end = columns_.begin() + row_start_[row + 1];
  const auto found = std::lower_bound(begin, end, column);
  return found != end && *found == column ? static_cast<Index>(found - columns_.begin())
                                          : Index{-1};
}

void BlockMatrix::set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

namespace {

struct Blocks {
  const Index *row_start, *columns;
  const double* values;
};

// Computes y = A x on the rows [begin, end). Each block column is read by one 4-wide load, whose
// fourth lane is meaningless; the fourth lane of the sum is set to zero. Three partial sums, one
// per column, keep the additions independent.
template <class>
LOOMSTONE_INLINE void multiply_rows(Index begin, Index end, Blocks matrix, const double* x,
                                    double* y, int stride) {
  const auto [row_start, columns, values] = matrix;
  for (Index row = begin; row < end; ++row) {
    Quad sum0{}, sum1{}, sum2{};
    for (Index k = row_start[row]; k < row_start[row + 1]; ++k) {
      const double* a = values + 9 * static_cast<std::size_t>(k);
      const double* v = x + stride * static_cast<std::size_t>(columns[k]);
      sum0 += quad_load(a) * v[0];
      sum1 += quad_load(a + 3) * v[1];
      sum2 += quad_load(a + 6) * v[2];
    }
    Quad sum = (sum0 + sum1) + sum2;
    sum[3] = 0.0;
    quad_store(y + 4 * static_cast<std::size_t>(row - begin), sum);
  }
}

}  // namespace

void BlockMatrix::multiply(Index begin, Index end, const double* x, double* y, int stride) const {
  const Blocks blocks{row_start_.data(), columns_.data(), values_.data()};
  LOOMSTONE_WIDEST(multiply_rows)(begin, end, blocks, x, y, stride);
}

}  // namespace loomstone
