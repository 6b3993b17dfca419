// Work that is divided among the ranks of a simulation. Each rank computes a part, and all ranks
// receive the results of all parts. If a part fails on any rank, all ranks throw the error of the
// lowest such rank. The messages that carry the results or their sizes also tell which parts have
// failed.
#pragma once

#include <cstdint>
#include <exception>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/agreement.h"
#include "core/parallel/communicator.h"

namespace loomstone {

// Range [begin, end) of indices.
struct IndexRange {
  Index begin = 0, end = 0;
  bool contains(Index i) const { return i >= begin && i < end; }
};
inline constexpr IndexRange all_indices = {0, std::numeric_limits<Index>::max()};

// Returns the part of [0, n) that rank `rank` of `size` ranks computes. The sizes of all parts
// differ by at most one.
inline IndexRange even_share(Index n, int rank, int size) {
  const auto start = [&](int r) {
    return static_cast<Index>(static_cast<std::int64_t>(n) * r / size);
  };
  return {start(rank), start(rank + 1)};
}

// Divides a sequence of pieces of work into `n_ranges` contiguous ranges of about the same cost.
// Returns the first piece of each range, followed by the number of pieces.
inline std::vector<std::size_t> contiguous_ranges(const std::vector<float>& costs, int n_ranges) {
  const double sum = std::accumulate(costs.begin(), costs.end(), 0.0);
  std::vector<std::size_t> starts{0};
  double done = 0.0;
  std::size_t next = 0;
  for (int range = 1; range < n_ranges; ++range) {
    while (next < costs.size() && done + 0.5 * costs[next] < sum * range / n_ranges)
      done += costs[next++];
    starts.push_back(next);
  }
  starts.push_back(costs.size());
  return starts;
}

// Collective. Returns the results of `work()` on all ranks, in the order of the ranks. Results are
// copied byte by byte.
template <class Work>
auto results_of_ranks(const Communicator& ranks, Work&& work) {
  using Result = decltype(work());
  std::vector<Result> results;
  if (ranks.size() == 1) {
    results.push_back(work());
    return results;
  }
  struct Slot {
    std::int64_t failed = 0;
    Result result{};
  };
  std::vector<Slot> slots(ranks.size());
  std::exception_ptr failure;
  try {
    slots[ranks.rank()].result = work();
  } catch (...) {
    failure = std::current_exception();
    slots[ranks.rank()].failed = 1;
  }
  std::vector<std::size_t> offsets;
  for (int rank = 0; rank <= ranks.size(); ++rank) offsets.push_back(rank * sizeof(Slot));
  ranks.gather_all(slots.data(), offsets);
  bool failed = false;
  for (const Slot& slot : slots) failed = failed || slot.failed != 0;
  if (failed) agree_on(ranks, failure);
  results.reserve(slots.size());
  for (const Slot& slot : slots) results.push_back(slot.result);
  return results;
}

// Elements from all ranks. Those of rank r are elements[start[r]] to elements[start[r + 1] - 1].
template <class Element>
struct Gathered {
  std::vector<Element> elements;
  std::vector<std::size_t> start;
};

// Collective. Returns the elements of the vectors that `work()` returns on all ranks. Elements are
// copied byte by byte.
template <class Work>
auto gather_from_ranks(const Communicator& ranks, Work&& work) {
  using Elements = decltype(work());
  using Element = typename Elements::value_type;
  Gathered<Element> all;
  if (ranks.size() == 1) {
    all.elements = work();
    all.start = {0, all.elements.size()};
    return all;
  }
  Elements own;
  const std::vector<std::size_t> sizes = results_of_ranks(ranks, [&] {
    own = work();
    return own.size();
  });
  std::vector<std::size_t> offsets{0};
  all.start = {0};
  for (const std::size_t size : sizes) {
    all.start.push_back(all.start.back() + size);
    offsets.push_back(sizeof(Element) * all.start.back());
  }
  if (all.start.back() == 0) return all;
  all.elements.resize(all.start.back());
  std::move(own.begin(), own.end(),
            all.elements.begin() + static_cast<std::ptrdiff_t>(all.start[ranks.rank()]));
  ranks.gather_all(all.elements.data(), offsets);
  return all;
}

}  // namespace loomstone
