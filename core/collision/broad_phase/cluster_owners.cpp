#include "core/collision/broad_phase/cluster_owners.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <utility>

namespace loomstone {

namespace {

// Ranges are cut again if the cost of the most expensive ones exceeds this multiple of the mean.
// Each cut moves lists to other ranks, which must make these lists again. Our choice.
constexpr double worth_a_cut = 1.1;
// Cost of making a list again, in units of the cost of an update of this list. Fitted to ListCosts
// in a twisted rope.
constexpr double remade = 4.0;

}  // namespace

ClusterOwners::ClusterOwners(const std::vector<Index>& n_clusters, const Communicator& ranks)
    : ranks_(ranks),
      first_(1, 0),
      rotates_(ranks.size() > 1 && std::getenv("LOOMSTONE_ROTATE_OWNERS") != nullptr),
      part_(ranks.rank()) {
  for (const Index n : n_clusters) first_.push_back(first_.back() + n);
  starts_ = section_ranges(std::vector<float>(first_.back(), 1.0f), first_, ranks.size());
  find_own_first();
}

void ClusterOwners::find_own_first() {
  own_first_ = {0};
  for (Index pair = 0; pair < n_pairs(); ++pair) {
    const IndexRange range = own(pair);
    own_first_.push_back(own_first_.back() + static_cast<std::size_t>(range.end - range.begin));
  }
}

bool ClusterOwners::cut(const std::vector<float>& own_costs, int updates) {
  if (ranks_.size() == 1) return false;
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
  const double present = imbalance(costs, first_, starts_);
  if (present <= worth_a_cut) return false;
  SectionRanges ranges = section_ranges(costs, first_, ranks_.size());
  const double mean = std::accumulate(costs.begin(), costs.end(), 0.0) / ranks_.size();
  const double saved = updates * mean * (present - imbalance(costs, first_, ranges));
  if (saved < remade * moved_cost(costs, ranges) / ranks_.size()) return false;
  starts_ = std::move(ranges);
  find_own_first();
  return true;
}

// Returns the cost of an update of the lists that `ranges` give to other ranks.
double ClusterOwners::moved_cost(const std::vector<float>& costs,
                                 const SectionRanges& ranges) const {
  double all = 0.0, kept = 0.0;
  const auto add = [&](double& sum, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sum += costs[i];
  };
  for (std::size_t s = 0; s < ranges.size(); ++s) {
    add(all, first_[s], first_[s + 1]);
    for (std::size_t r = 0; r + 1 < ranges[s].size(); ++r)
      add(kept, std::max(starts_[s][r], ranges[s][r]),
          std::min(starts_[s][r + 1], ranges[s][r + 1]));
  }
  return all - kept;
}

void ClusterOwners::rotate() {
  turn_ = (turn_ + 1) % ranks_.size();
  part_ = (ranks_.rank() + turn_) % ranks_.size();
  find_own_first();
}

}  // namespace loomstone
