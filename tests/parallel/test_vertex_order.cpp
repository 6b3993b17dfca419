#include <catch2/catch.hpp>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <thread>

#include "core/parallel/team.h"
#include "core/parallel/vertex_order.h"

using namespace loomstone;

namespace {

// Graph of a triangulated square: grid edges and one diagonal per cell.
Graph grid(Index side) {
  Graph graph;
  graph.start.push_back(0);
  for (Index r = 0; r < side; ++r)
    for (Index c = 0; c < side; ++c) {
      for (const auto& [dr, dc] :
           {std::pair<Index, Index>{-1, -1}, {-1, 0}, {0, -1}, {0, 1}, {1, 0}, {1, 1}})
        if (r + dr >= 0 && r + dr < side && c + dc >= 0 && c + dc < side)
          graph.adjacent.push_back((r + dr) * side + c + dc);
      graph.start.push_back(static_cast<Index>(graph.adjacent.size()));
    }
  return graph;
}

// Returns the number of vertices whose position is in [begin, end) and that have a neighbour
// outside this range.
Index boundary(const Graph& graph, const std::vector<Index>& place, Index begin, Index end) {
  Index count = 0;
  for (std::size_t vertex = 0; vertex < place.size(); ++vertex) {
    if (place[vertex] < begin || place[vertex] >= end) continue;
    bool outside = false;
    for (Index k = graph.start[vertex]; k < graph.start[vertex + 1]; ++k)
      outside |= place[graph.adjacent[k]] < begin || place[graph.adjacent[k]] >= end;
    count += outside;
  }
  return count;
}

std::vector<Index> places(const std::vector<Index>& order) {
  std::vector<Index> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<Index>(i);
  return place;
}

}  // namespace

TEST_CASE("the bisection order is a permutation and the same each time") {
  for (const Index side : {1, 7, 12, 60}) {
    const Graph graph = grid(side);
    const std::vector<Index> order = bisection_order(graph);
    CHECK(order == bisection_order(graph));
    std::vector<Index> sorted = order, all(side * side);
    std::sort(sorted.begin(), sorted.end());
    std::iota(all.begin(), all.end(), 0);
    CHECK(sorted == all);
  }
  CHECK(bisection_order(Graph{}).empty());
}

TEST_CASE("contiguous ranges of a grid have short boundaries") {
  const Index side = 86;  // 7,396 vertices
  const Graph graph = grid(side);
  const std::vector<Index> place = places(bisection_order(graph));
  for (const Index ranges : {2, 3, 4, 8}) {
    const Index n = side * side, n_blocks = (n + rows_per_block - 1) / rows_per_block;
    for (Index i = 0; i < ranges; ++i) {
      const Index begin = std::min(n, n_blocks * i / ranges * rows_per_block);
      const Index end = std::min(n, n_blocks * (i + 1) / ranges * rows_per_block);
      // The boundary of a square patch of n vertices has about 4 sqrt(n) vertices. The bound is
      // twice as large, because ranges need not be square.
      CHECK(boundary(graph, place, begin, end) < 8.0 * std::sqrt(1.0 * (end - begin)));
    }
  }
}

TEST_CASE("separate components and isolated vertices are ordered too") {
  Graph graph;
  graph.start.assign(1001, 0);  // 1,000 vertices without neighbours
  std::vector<Index> order = bisection_order(graph);
  std::sort(order.begin(), order.end());
  for (Index i = 0; i < 1000; ++i) REQUIRE(order[i] == i);
}

TEST_CASE("threads that order graphs at the same time find the order that one thread finds") {
  const Graph graph = grid(40);
  const std::vector<Index> alone = bisection_order(graph);
  std::atomic<int> different = 0;
  const auto order_often = [&] {
    for (int i = 0; i < 100; ++i) different += bisection_order(graph) != alone;
  };
  std::thread other(order_often);
  order_often();
  other.join();
  CHECK(different == 0);
}
