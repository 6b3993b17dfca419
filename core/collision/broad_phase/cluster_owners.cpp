#include "core/collision/broad_phase/cluster_owners.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace loomstone {

namespace {

// The ranges are cut again if the cost of the most expensive range exceeds this multiple of the
// mean cost. Each cut moves lists to other ranks, which must make them again. Our choice.
constexpr double worth_a_cut = 1.1;

}  // namespace

ClusterOwners::ClusterOwners(const std::vector<Index>& n_clusters, const Communicator& ranks)
    : ranks_(ranks),
      first_(1, 0),
      cut_(ranks.size() + 1, 0),
      rotates_(ranks.size() > 1 && std::getenv("LOOMSTONE_ROTATE_OWNERS") != nullptr),
      part_(ranks.rank()) {
  for (const Index n : n_clusters) first_.push_back(first_.back() + n);
  cut_by(std::vector<float>(first_.back(), 1.0f));
}

IndexRange ClusterOwners::own(Index pair) const {
  const std::size_t begin = std::clamp(cut_[part_], first_[pair], first_[pair + 1]),
                    end = std::clamp(cut_[part_ + 1], first_[pair], first_[pair + 1]);
  return {static_cast<Index>(begin - first_[pair]), static_cast<Index>(end - first_[pair])};
}

void ClusterOwners::cut(const std::vector<float>& own_costs) {
  if (ranks_.size() == 1) return;
  const Gathered<float> all = gather_from_ranks(ranks_, [&] { return own_costs; });
  std::vector<float> costs(first_.back());
  double most = 0.0, sum = 0.0;
  for (int rank = 0; rank < ranks_.size(); ++rank) {
    const auto begin = all.elements.begin() + static_cast<std::ptrdiff_t>(all.start[rank]),
               end = all.elements.begin() + static_cast<std::ptrdiff_t>(all.start[rank + 1]);
    std::copy(begin, end,
              costs.begin() + static_cast<std::ptrdiff_t>(cut_[(rank + turn_) % ranks_.size()]));
    const double cost = std::accumulate(begin, end, 0.0);
    most = std::max(most, cost);
    sum += cost;
  }
  if (most * ranks_.size() > worth_a_cut * sum) cut_by(costs);
}

void ClusterOwners::cut_by(const std::vector<float>& costs) {
  cut_ = contiguous_ranges(costs, ranks_.size());
}

void ClusterOwners::rotate() {
  turn_ = (turn_ + 1) % ranks_.size();
  part_ = (ranks_.rank() + turn_) % ranks_.size();
}

}  // namespace loomstone
