#include "core/linalg/sliced_ellpack.h"

#include <algorithm>
#include <numeric>

namespace loomstone {

bool SlicedEllpack::is_pattern_of(const BlockMatrix* matrix, Range range) const {
  if (range.n_rows != range_.n_rows || range.begin != range_.begin || range.end != range_.end ||
      (matrix ? matrix->n_rows() : 0) != n_coupled_)
    return false;
  return n_coupled_ == 0 ||
         (matrix->row_start() == pattern_start_ && matrix->columns() == pattern_columns_);
}

bool SlicedEllpack::set_pattern(const BlockMatrix* matrix, Range range) {
  if (is_pattern_of(matrix, range)) return false;
  range_ = range, n_coupled_ = matrix ? matrix->n_rows() : 0;
  pattern_start_.clear(), pattern_columns_.clear();
  if (n_coupled_ > 0) pattern_start_ = matrix->row_start(), pattern_columns_ = matrix->columns();

  const Index size = range.end - range.begin;
  rows.resize(8 * static_cast<std::size_t>((size + 7) / 8));
  std::iota(rows.begin(), rows.end(), range.begin);
  for (Index i = 0; i < size; i += rows_per_block)
    std::stable_sort(rows.begin() + i, rows.begin() + std::min<Index>(size, i + rows_per_block),
                     [&](Index a, Index b) { return n_beside(a) > n_beside(b); });
  std::fill(rows.begin() + size, rows.end(), range.n_rows);
  place.assign(range.n_rows, -1);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i] < range.n_rows) place[rows[i]] = static_cast<Index>(i);

  slot_start.assign(1, 0);
  columns.clear(), sources.clear();
  for (std::size_t i = 0; i < rows.size(); i += 8) add_slice(rows.data() + i);
  columns.shrink_to_fit(), sources.shrink_to_fit();
  return true;
}

void SlicedEllpack::add_slice(const Index* of_slice) {
  Index n_slots = 0;
  for (int l = 0; l < 8; ++l)
    if (of_slice[l] < range_.n_rows) n_slots = std::max(n_slots, n_beside(of_slice[l]));
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
