// Distribution of neighbour lists over ranks. Each list belongs to two clusters, the first of which
// is part of the first surface of a surface pair. For each surface pair, these first clusters are
// cut into one contiguous, possibly empty range for each rank, and a rank computes the lists whose
// first cluster is in its range. The cuts depend on the costs of earlier steps. They determine
// which rank computes a list, but not what the list contains. Each expensive surface pair is cut
// separately, because some pairs have many contacts and others have many feature pairs to test for
// impacts. Each rank thus gets about an equal part of the searches for contacts and for impacts.
// All other surface pairs are cut together: their first clusters, sorted by surface pair, form one
// sequence.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/parallel/section_ranges.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

class ClusterOwners {
 public:
  // `n_clusters` contains the number of first clusters of each surface pair. At the start, all of
  // these clusters are given the same cost.
  ClusterOwners(const std::vector<Index>& n_clusters, const Communicator& ranks);

  // For a surface pair, returns the range of first clusters whose lists this rank computes.
  IndexRange own(Index pair) const { return range(pair, part_); }
  // Returns the position of a first cluster among the first clusters of this rank, which are sorted
  // by surface pair.
  std::size_t own_index(Index pair, Index cluster) const {
    return own_first_[pair] + static_cast<std::size_t>(cluster - own(pair).begin);
  }
  std::size_t n_own() const { return own_first_.back(); }
  std::size_t bytes() const { return bytes_of(first_, starts_, own_first_); }

  // Collective. `own_costs` has one entry for each first cluster of this rank. Cuts the first
  // clusters into new ranges if the costs of the present ranges differ too much. Boundaries near
  // their best places stay, because a list that moves to another rank must be made again there.
  void cut(const std::vector<float>& own_costs);
  // Returns true if the environment variable LOOMSTONE_ROTATE_OWNERS is set and there are several
  // ranks. Tests set this variable to change the owners in every search.
  bool rotates() const { return rotates_; }
  // Gives each range to the preceding rank, and the range of rank 0 to the last rank.
  void rotate();

 private:
  IndexRange range(Index pair, int part) const {
    return {static_cast<Index>(starts_[pair][part] - first_[pair]),
            static_cast<Index>(starts_[pair][part + 1] - first_[pair])};
  }
  Index n_pairs() const { return static_cast<Index>(starts_.size()); }
  void find_own_first();

  const Communicator& ranks_;
  // Position of each surface pair's first entry in the sequence of all first clusters, followed by
  // the length of the sequence.
  SectionStarts first_;
  SectionRanges starts_;  // ranges of each surface pair, as positions in the sequence of first_
  // (surface pairs + 1) For each surface pair, the number of first clusters of this rank in all
  // preceding surface pairs. The last entry is the number in all surface pairs.
  std::vector<std::size_t> own_first_;
  const bool rotates_;
  // In each surface pair, rank r owns the range with index (r + turn_) modulo the number of ranks.
  // This rank owns range part_.
  int turn_ = 0, part_;
};

}  // namespace loomstone
