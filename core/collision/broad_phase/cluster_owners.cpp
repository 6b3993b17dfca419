#include "core/collision/broad_phase/cluster_owners.h"

#include <algorithm>
#include <cstdlib>

namespace loomstone {

namespace {

// Ranges are cut again if their imbalance() exceeds this value. The lists that then move to another
// rank must be made again there. Our choice.
constexpr double worth_a_cut = 1.1;
// When ranges are cut again, a boundary between two ranges stays in place if the clusters between
// it and its best place cost at most this fraction of the mean cost of a range. The mean is taken
// over the surface pairs that are cut together. Our choice.
constexpr double close_enough = 0.05;

}  // namespace

ClusterOwners::ClusterOwners(const std::vector<Index>& n_clusters, const Communicator& ranks)
    : ranks_(ranks),
      first_(1, 0),
      rotates_(ranks.size() > 1 && std::getenv("LOOMSTONE_ROTATE_OWNERS") != nullptr),
      part_(ranks.rank()) {
  for (const Index n : n_clusters) first_.push_back(first_.back() + n);
  starts_ = section_ranges(std::vector<float>(first_.back(), 1.0f), first_, ranks_.size());
  find_own_first();
}

void ClusterOwners::find_own_first() {
  own_first_ = {0};
  for (Index pair = 0; pair < n_pairs(); ++pair) {
    const IndexRange range = own(pair);
    own_first_.push_back(own_first_.back() + static_cast<std::size_t>(range.end - range.begin));
  }
}

void ClusterOwners::cut(const std::vector<float>& own_costs) {
  if (ranks_.size() == 1) return;
  const Gathered<float> all = gather_from_ranks(ranks_, [&] { return own_costs; });
  std::vector<float> costs(first_.back());
  auto next = all.elements.begin();
  for (int rank = 0; rank < ranks_.size(); ++rank)
    for (const std::vector<std::size_t>& starts : starts_) {
      const std::size_t part = (rank + turn_) % ranks_.size();
      const auto end = next + static_cast<std::ptrdiff_t>(starts[part + 1] - starts[part]);
      std::copy(next, end, costs.begin() + static_cast<std::ptrdiff_t>(starts[part]));
      next = end;
    }
  if (imbalance(costs, first_, starts_) <= worth_a_cut) return;
  starts_ = section_ranges(costs, first_, starts_, close_enough);
  find_own_first();
}

void ClusterOwners::rotate() {
  turn_ = (turn_ + 1) % ranks_.size();
  part_ = (ranks_.rank() + turn_) % ranks_.size();
  find_own_first();
}

}  // namespace loomstone
