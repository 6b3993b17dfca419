// Orders vertices by recursive bisection with METIS (Karypis and Kumar, "A fast and high quality
// multilevel scheme for partitioning irregular graphs", SIAM J. Sci. Comput. 20 (1998)). Only this
// file includes METIS.
#include "core/parallel/vertex_order.h"

#include <metis.h>

#include <array>
#include <mutex>
#include <numeric>

#include "core/parallel/team.h"

namespace loomstone {

namespace {

static_assert(sizeof(idx_t) == 4, "METIS with 32-bit indices is expected");

class Bisection {
 public:
  explicit Bisection(const Graph& graph)
      : graph_(graph), local_(graph.start.size() - 1, -1), order_(graph.start.size() - 1) {
    std::iota(order_.begin(), order_.end(), Index{0});
  }

  std::vector<Index> order() {
    split(0, static_cast<Index>(order_.size()));
    return std::move(order_);
  }

 private:
  // Orders the vertices at positions [begin, end).
  void split(Index begin, Index end) {
    const Index n = end - begin, n_blocks = (n + rows_per_block - 1) / rows_per_block;
    if (n_blocks <= 1) return breadth_first(begin, end);
    extract(begin, end);
    // The wanted size of the first part is a multiple of rows_per_block, so that cuts of the
    // bisection are close to boundaries between blocks of rows.
    const Index target = n_blocks / 2 * rows_per_block;
    const Index middle = begin + bisect(begin, n, target);
    split(begin, middle);
    split(middle, end);
  }

  // Extracts the subgraph of the vertices at positions [begin, end). The local index of a vertex is
  // its position minus `begin`.
  void extract(Index begin, Index end) {
    for (Index place = begin; place < end; ++place) local_[order_[place]] = place - begin;
    sub_start_.assign(1, 0);
    sub_adjacent_.clear();
    for (Index place = begin; place < end; ++place) {
      const Index vertex = order_[place];
      for (Index k = graph_.start[vertex]; k < graph_.start[vertex + 1]; ++k) {
        const Index other = graph_.adjacent[k];
        if (other != vertex && local_[other] >= 0) sub_adjacent_.push_back(local_[other]);
      }
      sub_start_.push_back(static_cast<idx_t>(sub_adjacent_.size()));
    }
    for (Index place = begin; place < end; ++place) local_[order_[place]] = -1;
  }

  // Bisects the extracted subgraph so that the first part has about `target` vertices. Moves
  // these vertices to the front and keeps the order within each part. Returns the size of the first
  // part.
  Index bisect(Index begin, Index n, Index target) {
    idx_t n_vertices = n, n_constraints = 1, n_parts = 2, cut = 0;
    std::array<real_t, 2> shares = {static_cast<real_t>(target) / n,
                                    static_cast<real_t>(n - target) / n};
    std::array<idx_t, METIS_NOPTIONS> options;
    METIS_SetDefaultOptions(options.data());
    options[METIS_OPTION_SEED] = 1;
    part_.assign(n, 0);
    // METIS uses the random number generator of the C library, which has one state for all threads.
    // Concurrent calls would therefore influence each other's results.
    static std::mutex one_at_a_time;
    const std::lock_guard<std::mutex> lock(one_at_a_time);
    METIS_PartGraphRecursive(&n_vertices, &n_constraints, sub_start_.data(), sub_adjacent_.data(),
                             nullptr, nullptr, nullptr, &n_parts, shares.data(), nullptr,
                             options.data(), &cut, part_.data());
    const Index first = n - std::accumulate(part_.begin(), part_.end(), Index{0});
    if (first == 0 || first == n) return target;  // METIS found no cut: keep the order
    moved_.clear();
    for (const idx_t side : {0, 1})
      for (Index i = 0; i < n; ++i)
        if (part_[i] == side) moved_.push_back(order_[begin + i]);
    std::copy(moved_.begin(), moved_.end(), order_.begin() + begin);
    return first;
  }

  // Orders the vertices at positions [begin, end) breadth-first, so that neighbours are close
  // together. Each connected component starts at the vertex that came first in the previous order.
  void breadth_first(Index begin, Index end) {
    for (Index place = begin; place < end; ++place) local_[order_[place]] = 0;
    moved_.clear();
    for (Index place = begin; place < end; ++place) {
      if (local_[order_[place]] != 0) continue;
      std::size_t next = moved_.size();
      moved_.push_back(order_[place]);
      local_[order_[place]] = -1;
      for (; next < moved_.size(); ++next) {
        const Index vertex = moved_[next];
        for (Index k = graph_.start[vertex]; k < graph_.start[vertex + 1]; ++k) {
          const Index other = graph_.adjacent[k];
          if (local_[other] != 0) continue;
          local_[other] = -1;
          moved_.push_back(other);
        }
      }
    }
    std::copy(moved_.begin(), moved_.end(), order_.begin() + begin);
  }

  const Graph& graph_;
  // (vertices) In extract(), the local index of each vertex of the subgraph. In breadth_first(), 0
  // for each vertex of the range that is not yet visited. In all other cases, -1.
  std::vector<Index> local_;
  std::vector<Index> order_, moved_;
  std::vector<idx_t> sub_start_, sub_adjacent_, part_;
};

}  // namespace

std::vector<Index> bisection_order(const Graph& graph) {
  if (graph.start.size() <= 1) return {};
  return Bisection(graph).order();
}

}  // namespace loomstone
