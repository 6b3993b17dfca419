// Distribution of neighbour lists over ranks. A list belongs to the owner of its first cluster. The
// first clusters of all surface pairs, in ascending order, are cut into one contiguous range for
// each rank. The cuts depend on the costs of earlier steps. They determine which rank computes a
// list, not its content.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

class ClusterOwners {
 public:
  // `n_clusters` contains the number of first clusters of each surface pair. At the start, all of
  // these clusters are given the same cost.
  ClusterOwners(const std::vector<Index>& n_clusters, const Communicator& ranks);

  // Returns the clusters of a surface pair whose lists this rank computes.
  IndexRange own(Index pair) const;
  // Returns the position of a first cluster of a surface pair in the range of this rank.
  std::size_t own_index(Index pair, Index cluster) const {
    return first_[pair] + cluster - own_begin();
  }
  std::size_t bytes() const { return bytes_of(first_, cut_); }
  std::size_t n_own() const { return cut_[part_ + 1] - cut_[part_]; }

  // Collective. `own_costs` has one entry for each first cluster in the range of this rank. Cuts
  // the first clusters into new ranges if the most expensive range costs much more than the mean.
  void cut(const std::vector<float>& own_costs);
  // Returns true if the environment variable LOOMSTONE_ROTATE_OWNERS is set and there are several
  // ranks. Tests set it to change the owners in every search.
  bool rotates() const { return rotates_; }
  // Gives each range to the next rank.
  void rotate();

 private:
  std::size_t own_begin() const { return cut_[part_]; }
  void cut_by(const std::vector<float>& costs);

  const Communicator& ranks_;
  // Index of the first entry of each surface pair in the list of all first clusters, and the length
  // of that list.
  std::vector<std::size_t> first_;
  std::vector<std::size_t> cut_;  // (ranges + 1) start of each range, and end of the last range
  const bool rotates_;
  // Rank r owns the range (r + turn_) modulo the number of ranks. This rank owns the range part_.
  int turn_ = 0, part_;
};

}  // namespace loomstone
