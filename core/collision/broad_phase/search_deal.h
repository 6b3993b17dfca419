// Divides among ranks the tests with which dynamic searches (Decomposition::Dynamic) start,
// according to the costs in the last search that measured costs. The clusters of all hierarchies,
// in order, are cut into one contiguous range for each rank. A rank starts with the tests in which
// node a contains only clusters of its range; see PartitionTrees::tests_of(). Costs determine which
// rank receives a test at the start. They do not affect results.
#pragma once

#include <cstddef>
#include <vector>

#include "core/parallel/shared_work.h"

namespace loomstone {

class SearchDeal {
 public:
  explicit SearchDeal(std::size_t n_clusters = 0) : n_clusters_(n_clusters) {}

  // One in every `interval` searches measures costs. Such a search is slower, because it reads the
  // clock twice in each test.
  static constexpr int interval = 8;

  // Starts a search. Returns whether it measures costs.
  bool begin(int threads);
  // Adds the cost [s] of a test. `cluster` is PartitionTrees::first_cluster() of the test. Threads
  // call this function concurrently.
  void add(int thread, std::size_t cluster, double seconds);
  // Collective. Ends a search that measures costs: cuts the clusters into `n_ranges` ranges of
  // about equal costs.
  void end(const Communicator& ranks, int n_ranges);

  // Averages over all searches: number of exchanges among ranks (two in each search that measures
  // costs, to gather them), and estimated size of the data that each rank receives in them [bytes].
  static constexpr double exchanges() { return 2.0 / interval; }
  double bytes() const;

  // Returns whether the clusters have been cut into ranges.
  bool known() const { return !starts_.empty(); }
  // First cluster of the range of each rank, followed by the number of clusters.
  const std::vector<std::size_t>& starts() const { return starts_; }

 private:
  const std::size_t n_clusters_;
  int searches_ = 0;
  std::vector<std::vector<float>> costs_;  // (threads x clusters) [s]
  std::vector<std::size_t> starts_;
};

}  // namespace loomstone
