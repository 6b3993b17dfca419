// Loops over the blocks of rows that this rank owns, and sums over the rows of all ranks. Each
// block is summed by one thread in a fixed order, and block sums are added by a BinnedSum. Results
// are therefore bitwise independent of the number of threads and ranks. Denormal numbers count as
// zero.
#pragma once

#include <algorithm>
#include <vector>

#include "core/linalg/flush_to_zero.h"
#include "core/linalg/sliced_ellpack.h"
#include "core/linalg/system.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

class RowLoops {
 public:
  RowLoops(const Team& team, const RowLayout& layout)
      : team_(team), layout_(layout), sums_(n_blocks(), 0.0) {}

  const Team& team() const { return team_; }
  const RowLayout& layout() const { return layout_; }
  // Number of blocks of rows on all ranks together.
  Index n_blocks() const { return (layout_.n_rows() + rows_per_block - 1) / rows_per_block; }

  // Calls body(block, begin, end) for each owned block, which consists of the rows [begin, end).
  // Each thread processes a range of blocks.
  template <class Body>
  void over_blocks(Body&& body) const {
    const OwnedBlocks owned = owned_blocks(layout_);
    const Index end_row = layout_.end(), n = owned.last - owned.first;
    parallel_ranges(team_, n, share_of(n), [&](Index first, Index last) {
      const FlushToZero flush;
      for (Index i = first; i < last; ++i) {
        const Index block = owned.first + i, begin = block * rows_per_block;
        body(block, begin, std::min<Index>(end_row, begin + rows_per_block));
      }
    });
  }

  // Sets the sum of each given block to body(begin, end), for its rows [begin, end). This rank must
  // own the blocks.
  template <class Body>
  void set_sums(const std::vector<Index>& blocks, Body&& body) {
    const Index end_row = layout_.end(), n = static_cast<Index>(blocks.size());
    parallel_ranges(team_, n, share_of(n), [&](Index first, Index last) {
      const FlushToZero flush;
      for (Index i = first; i < last; ++i) {
        const Index begin = blocks[i] * rows_per_block;
        sums_[blocks[i]] = body(begin, std::min<Index>(end_row, begin + rows_per_block));
      }
    });
  }
  // Returns the total of the sums of the owned blocks.
  BinnedSum owned_sum() const { return layout_.owned_sum(sums_); }

  // Returns the sum of body(begin, end) over all blocks of all ranks. Collective.
  template <class Body>
  double sum_over_blocks(Body&& body) {
    over_blocks([&](Index block, Index begin, Index end) { sums_[block] = body(begin, end); });
    return layout_.sum(sums_);
  }

  // Returns the sum of body(first, last) over the owned blocks, where [first, last) are the slices
  // of a block.
  template <class Body>
  BinnedSum owned_sum_over_slices(const SlicedEllpack& slices, Body&& body) {
    over_blocks([&](Index block, Index begin, Index end) {
      sums_[block] = body(slices.first_slice(begin), slices.last_slice(end));
    });
    return owned_sum();
  }

 private:
  static constexpr Index least_blocks_a_thread = 4;  // 512 rows

  Index share_of(Index n_blocks) const {  // number of blocks in a range
    return std::max(least_blocks_a_thread, (n_blocks + team_.threads - 1) / team_.threads);
  }

  Team team_;
  const RowLayout& layout_;
  std::vector<double> sums_;  // (blocks)
};

}  // namespace loomstone
