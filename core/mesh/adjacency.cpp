// Builds the edge table by sorting half-edges, and incidence lists by counting sort.
#include "core/mesh/adjacency.h"

#include <algorithm>

#include "core/base/message.h"

namespace loomstone {
namespace {

struct HalfEdge {
  Index low, high;  // vertices of the edge
  Index triangle;
  Index corner;  // corner opposite the edge

  bool same_edge(const HalfEdge& other) const { return low == other.low && high == other.high; }
};

std::vector<HalfEdge> sorted_half_edges(const Triangles& triangles) {
  std::vector<HalfEdge> halves;
  halves.reserve(3 * static_cast<std::size_t>(triangles.rows()));
  for (Index t = 0; t < triangles.rows(); ++t) {
    for (Index c = 0; c < 3; ++c) {
      const Index a = triangles(t, (c + 1) % 3), b = triangles(t, (c + 2) % 3);
      halves.push_back({std::min(a, b), std::max(a, b), t, c});
    }
  }
  std::sort(halves.begin(), halves.end(), [](const HalfEdge& a, const HalfEdge& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.triangle < b.triangle;
  });
  return halves;
}

// Converts counts to offsets. On entry, start[i + 1] is the number of items of list i.
void accumulate(std::vector<Index>& start) {
  for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
}

Index corner_of(const Triangles& triangles, Index triangle, Index vertex) {
  for (Index c = 0; c < 3; ++c) {
    if (triangles(triangle, c) == vertex) return c;
  }
  return -1;
}

// Returns, for each vertex, the list of the rows of a table that contain it.
template <class Table>
Incidence rows_of_vertices(Index n_vertices, const Table& table) {
  Incidence lists;
  lists.start.assign(static_cast<std::size_t>(n_vertices) + 1, 0);
  lists.items.resize(static_cast<std::size_t>(table.size()));
  for (Index row = 0; row < table.rows(); ++row)
    for (Index c = 0; c < table.cols(); ++c)
      ++lists.start[static_cast<std::size_t>(table(row, c)) + 1];
  accumulate(lists.start);
  std::vector<Index> next(lists.start.begin(), lists.start.end() - 1);
  for (Index row = 0; row < table.rows(); ++row)
    for (Index c = 0; c < table.cols(); ++c)
      lists.items[static_cast<std::size_t>(next[static_cast<std::size_t>(table(row, c))]++)] = row;
  return lists;
}

}  // namespace

EdgeTable edge_table(Index n_vertices, const Triangles& triangles) {
  const std::vector<HalfEdge> halves = sorted_half_edges(triangles);
  if (!halves.empty()) {
    Index highest = 0;
    for (const HalfEdge& half : halves) highest = std::max(highest, half.high);
    if (halves.front().low < 0 || highest >= n_vertices) {
      fail<InvalidInput>("triangles must index vertices 0 to {}, got {}; check the triangle array",
                         n_vertices - 1, halves.front().low < 0 ? halves.front().low : highest);
    }
  }
  EdgeTable table;
  table.of_triangle.resize(static_cast<std::size_t>(triangles.rows()));
  std::vector<HalfEdge> firsts;
  for (std::size_t i = 0; i < halves.size(); ++i) {
    const HalfEdge& half = halves[i];
    if (i == 0 || !half.same_edge(halves[i - 1])) {
      firsts.push_back(half);
      table.triangles.push_back({half.triangle, -1});
    } else if (table.triangles.back()[1] < 0) {
      table.triangles.back()[1] = half.triangle;
    } else {
      fail<InvalidInput>(
          "an edge must have one or two triangles, but edge ({}, {}) has more: {}, {}, {}; split "
          "the surface there",
          half.low, half.high, table.triangles.back()[0], table.triangles.back()[1], half.triangle);
    }
    table.of_triangle[static_cast<std::size_t>(half.triangle)]
                     [static_cast<std::size_t>(half.corner)] =
        static_cast<Index>(firsts.size()) - 1;
  }
  table.edges.resize(static_cast<Eigen::Index>(firsts.size()), 2);
  for (std::size_t e = 0; e < firsts.size(); ++e) {
    table.edges.row(static_cast<Eigen::Index>(e)) << firsts[e].low, firsts[e].high;
  }
  return table;
}

std::vector<Hinge> hinges(const Triangles& triangles, const EdgeTable& table) {
  std::vector<Hinge> result;
  for (std::size_t e = 0; e < table.triangles.size(); ++e) {
    const auto [first, second] = table.triangles[e];
    if (second < 0) continue;
    const std::array<Index, 3>& own = table.of_triangle[static_cast<std::size_t>(first)];
    const Index c =
        static_cast<Index>(std::find(own.begin(), own.end(), static_cast<Index>(e)) - own.begin());
    const Index x1 = triangles(first, c), x3 = triangles(first, (c + 1) % 3),
                x4 = triangles(first, (c + 2) % 3);
    const Index x2 = triangles(second, (corner_of(triangles, second, x4) + 2) % 3);
    result.push_back({{x1, x2, x3, x4}, {first, second}, static_cast<Index>(e)});
  }
  return result;
}

Incidence triangles_of_vertices(Index n_vertices, const Triangles& triangles) {
  return rows_of_vertices(n_vertices, triangles);
}

Incidence edges_of_vertices(Index n_vertices, const Edges& edges) {
  return rows_of_vertices(n_vertices, edges);
}

Incidence vertex_graph(Index n_vertices, const Triangles& triangles) {
  const Edges edges = edge_table(n_vertices, triangles).edges;
  Incidence lists = edges_of_vertices(n_vertices, edges);
  // Edges are sorted by (low, high). In the list of a vertex, neighbours with lower indices than
  // the vertex therefore come first, and the list is ascending.
  for (Index vertex = 0; vertex < n_vertices; ++vertex) {
    const auto begin = lists.items.begin() + lists.start[static_cast<std::size_t>(vertex)];
    const auto end = lists.items.begin() + lists.start[static_cast<std::size_t>(vertex) + 1];
    for (auto item = begin; item != end; ++item)
      *item = edges(*item, 0) == vertex ? edges(*item, 1) : edges(*item, 0);
  }
  return lists;
}

}  // namespace loomstone
