#include "core/linalg/sliced_ellpack.h"

#include <algorithm>
#include <numeric>

namespace loomstone {

bool SlicedEllpack::is_pattern_of(const BlockMatrix* matrix, Index n_rows) const {
  if (n_rows != n_rows_ || (matrix ? matrix->n_rows() : 0) != n_coupled_) return false;
  return n_coupled_ == 0 ||
         (matrix->row_start() == pattern_start_ && matrix->columns() == pattern_columns_);
}

bool SlicedEllpack::set_pattern(const BlockMatrix* matrix, Index n_rows) {
  if (is_pattern_of(matrix, n_rows)) return false;
  n_rows_ = n_rows, n_coupled_ = matrix ? matrix->n_rows() : 0;
  pattern_start_.clear(), pattern_columns_.clear();
  if (n_coupled_ > 0) pattern_start_ = matrix->row_start(), pattern_columns_ = matrix->columns();
  build(0, n_rows);
  return true;
}

void SlicedEllpack::set_pattern(const BlockMatrix& matrix, Index begin, Index end) {
  n_rows_ = n_coupled_ = matrix.n_rows();
  pattern_start_ = matrix.row_start(), pattern_columns_ = matrix.columns();
  build(begin, end);
}

void SlicedEllpack::build(Index begin, Index end) {
  rows.resize(8 * static_cast<std::size_t>(last_slice(end - begin)));
  std::iota(rows.begin(), rows.end(), begin);
  for (Index i = 0; i < end - begin; i += rows_per_block)
    std::stable_sort(rows.begin() + i,
                     rows.begin() + std::min<Index>(end - begin, i + rows_per_block),
                     [&](Index a, Index b) { return n_beside(a) > n_beside(b); });
  std::fill(rows.begin() + (end - begin), rows.end(), n_rows_);
  place.assign(n_rows_, -1);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i] < n_rows_) place[rows[i]] = static_cast<Index>(i);

  slot_start.assign(1, 0);
  columns.clear(), sources.clear();
  for (std::size_t i = 0; i < rows.size(); i += 8) add_slice(rows.data() + i);
}

void SlicedEllpack::add_slice(const Index* of_slice) {
  Index n_slots = 0;
  for (int l = 0; l < 8; ++l)
    if (of_slice[l] < n_rows_) n_slots = std::max(n_slots, n_beside(of_slice[l]));
  const std::size_t first = columns.size();
  slot_start.push_back(slot_start.back() + n_slots);
  columns.resize(8 * static_cast<std::size_t>(slot_start.back()));
  sources.resize(columns.size(), -1);
  for (int l = 0; l < 8; ++l) {
    const Index row = of_slice[l];
    for (std::size_t i = first + l; i < columns.size(); i += 8) columns[i] = row;
    if (row >= n_coupled_) continue;
    std::size_t i = first + l;
    for (Index k = pattern_start_[row]; k < pattern_start_[row + 1]; ++k) {
      if (pattern_columns_[k] == row) continue;
      columns[i] = pattern_columns_[k], sources[i] = k;
      i += 8;
    }
  }
}

}  // namespace loomstone
