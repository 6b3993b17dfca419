#include "core/linalg/aggregates.h"

#include <algorithm>

namespace loomstone {

namespace {

// Target number of rows of an aggregate. On matrices of a falling drape, 16 rows lead to 1.02 to
// 1.12 times as many iterations as 12 (docs/experiments/solver.md). With 8 rows, the coarse level
// has about 1.5 times as many nodes as with 12.
constexpr Index grown_size = 12;

// Groups the rows [begin, end) of a block into aggregates.
class Block {
 public:
  Block(const BlockMatrix& matrix, Index begin, Index end, std::vector<Index>& of_row)
      : matrix_(matrix), begin_(begin), end_(end), of_row_(of_row), links_(end - begin) {}

  // Groups the rows into aggregates, which are numbered from `first` on. An aggregate of fewer than
  // grown_size / 2 rows is merged into an earlier aggregate of the block: the one with which it has
  // the most couplings, if it has any. Returns the next free number.
  Index grow(Index first) {
    Index next = first;
    for (Index seed = begin_; seed < end_; ++seed) {
      if (of_row_[seed] >= 0) continue;
      members_.clear();
      std::fill(links_.begin(), links_.end(), 0);
      for (Index row = seed; row >= 0 && size() < grown_size; row = most_linked()) take(row, next);
      const Index other = 2 * size() < grown_size ? neighbour(first, next) : -1;
      if (other < 0) {
        ++next;
        continue;
      }
      for (const Index row : members_) of_row_[row] = other;
    }
    return next;
  }

 private:
  Index size() const { return static_cast<Index>(members_.size()); }

  void take(Index row, Index aggregate) {
    of_row_[row] = aggregate;
    members_.push_back(row);
    for_coupled(row, [&](Index other) { ++links_[other - begin_]; });
  }

  // Returns the unassigned row with the most couplings to the current aggregate, or -1 if no
  // unassigned row is coupled to it. In a tie, the lowest index is taken.
  Index most_linked() const {
    Index best = -1, most = 0;
    for (Index row = begin_; row < end_; ++row)
      if (of_row_[row] < 0 && links_[row - begin_] > most) best = row, most = links_[row - begin_];
    return best;
  }

  // Returns the aggregate with an index in [first, last) that has the most couplings to the current
  // members, or -1 if none is coupled to them.
  Index neighbour(Index first, Index last) const {
    std::vector<Index> count(last - first, 0);
    for (const Index row : members_)
      for_coupled(row, [&](Index other) {
        if (of_row_[other] >= first && of_row_[other] < last) ++count[of_row_[other] - first];
      });
    const auto most = std::max_element(count.begin(), count.end());
    return most == count.end() || *most == 0 ? Index{-1}
                                             : first + static_cast<Index>(most - count.begin());
  }

  template <class Body>
  void for_coupled(Index row, Body&& body) const {
    for (Index k = matrix_.row_start()[row]; k < matrix_.row_start()[row + 1]; ++k)
      if (const Index other = matrix_.columns()[k]; other >= begin_ && other < end_) body(other);
  }

  const BlockMatrix& matrix_;
  Index begin_, end_;
  std::vector<Index>& of_row_;
  std::vector<Index> links_, members_;
};

}  // namespace

namespace {

// Gathers entries from all ranks. Rank r contributes the entries [starts[r], starts[r + 1]).
void gather(const RowLayout& layout, const std::vector<Index>& starts, std::vector<Index>& list) {
  std::vector<std::size_t> offsets;
  for (const Index start : starts)
    offsets.push_back(sizeof(Index) * static_cast<std::size_t>(start));
  layout.communicator().gather_all(list.data(), offsets);
}

}  // namespace

Aggregates grow_aggregates(const BlockMatrix& matrix, const RowLayout& layout) {
  const Index n_rows = matrix.n_rows(), n_blocks = (n_rows + rows_per_block - 1) / rows_per_block;
  // (ranks + 1) First row and first block of each rank, limited to the rows of the matrix. Rows of
  // bodies follow these rows and have no aggregates.
  std::vector<Index> rows, blocks;
  for (const Index start : layout.starts()) {
    rows.push_back(std::min(start, n_rows));
    blocks.push_back(std::min((start + rows_per_block - 1) / rows_per_block, n_blocks));
  }
  const int rank = layout.communicator().rank();
  Aggregates made;
  made.of_row.assign(n_rows, -1);
  std::vector<Index> counts(n_blocks, 0);
  for (Index block = blocks[rank]; block < blocks[rank + 1]; ++block) {
    const Index begin = block * rows_per_block, end = std::min(n_rows, begin + rows_per_block);
    counts[block] = Block(matrix, begin, end, made.of_row).grow(0);
  }
  if (!layout.single()) gather(layout, blocks, counts), gather(layout, rows, made.of_row);
  made.block_start.assign(1, 0);
  for (const Index count : counts) made.block_start.push_back(made.count() + count);
  for (Index row = 0; row < n_rows; ++row)
    made.of_row[row] += made.block_start[row / rows_per_block];
  return made;
}

}  // namespace loomstone
