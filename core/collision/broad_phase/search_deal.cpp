#include "core/collision/broad_phase/search_deal.h"

#include <algorithm>

namespace loomstone {

namespace {

// Upper bound on the recorded cost of one test [s]. A test that seems to take longer was probably
// interrupted.
constexpr double most_seconds = 2e-5;

struct ClusterCost {
  std::int32_t cluster;
  float seconds;
};

}  // namespace

bool SearchDeal::begin(int threads) {
  if (searches_++ % interval != 0) return false;
  costs_.resize(std::max(1, threads));
  for (std::vector<float>& costs : costs_) costs.assign(n_clusters_, 0.0f);
  return true;
}

double SearchDeal::bytes() const {
  return static_cast<double>(n_clusters_ * sizeof(ClusterCost)) / interval;
}

void SearchDeal::add(int thread, std::size_t cluster, double seconds) {
  costs_[thread][cluster] += static_cast<float>(std::min(seconds, most_seconds));
}

void SearchDeal::end(const Communicator& ranks, int n_ranges) {
  const Gathered<ClusterCost> all = gather_from_ranks(ranks, [&] {
    std::vector<ClusterCost> own;
    for (std::size_t c = 0; c < n_clusters_; ++c) {
      float sum = 0.0f;
      for (const std::vector<float>& costs : costs_) sum += costs[c];
      if (sum > 0.0f) own.push_back({static_cast<std::int32_t>(c), sum});
    }
    return own;
  });
  std::vector<float> sums(n_clusters_, 0.0f);
  for (const ClusterCost& each : all.elements) sums[each.cluster] += each.seconds;
  starts_ = contiguous_ranges(sums, n_ranges);
}

}  // namespace loomstone
