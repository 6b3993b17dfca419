// Sorting half-edges gives the edge table; counting sorts give the incidence lists.
#include "core/mesh/adjacency.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"

namespace loomstone {
namespace {

struct HalfEdge {
  Index low, high;  // vertices of the edge
  Index triangle;
  Index corner;     // the corner opposite

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

// Turns counts in start[i + 1] into offsets.
void accumulate(std::vector<Index>& start) {
  for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
}

Index corner_of(const Triangles& triangles, Index triangle, Index vertex) {
  for (Index c = 0; c < 3; ++c) {
    if (triangles(triangle, c) == vertex) return c;
  }
  return -1;
}

}  // namespace

EdgeTable edge_table(Index n_vertices, const Triangles& triangles) {
  const std::vector<HalfEdge> halves = sorted_half_edges(triangles);
  if (!halves.empty()) {
    Index highest = 0;
    for (const HalfEdge& half : halves) highest = std::max(highest, half.high);
    if (halves.front().low < 0 || highest >= n_vertices) {
      throw InvalidInput("triangles must index vertices 0 to " + std::to_string(n_vertices - 1) +
                         ", got an index outside; check the triangle array");
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
      throw InvalidInput("an edge must have one or two triangles, but edge (" + std::to_string(half.low) + ", " +
                         std::to_string(half.high) + ") has more: " + std::to_string(table.triangles.back()[0]) +
                         ", " + std::to_string(table.triangles.back()[1]) + ", " + std::to_string(half.triangle) +
                         "; split the surface there");
    }
    table.of_triangle[static_cast<std::size_t>(half.triangle)][static_cast<std::size_t>(half.corner)] =
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
    const Index c = static_cast<Index>(std::find(own.begin(), own.end(), static_cast<Index>(e)) - own.begin());
    const Index x1 = triangles(first, c), x3 = triangles(first, (c + 1) % 3), x4 = triangles(first, (c + 2) % 3);
    const Index x2 = triangles(second, (corner_of(triangles, second, x4) + 2) % 3);
    result.push_back({{x1, x2, x3, x4}, {first, second}, static_cast<Index>(e)});
  }
  return result;
}

Incidence triangles_of_vertices(Index n_vertices, const Triangles& triangles) {
  Incidence lists;
  lists.start.assign(static_cast<std::size_t>(n_vertices) + 1, 0);
  lists.items.resize(static_cast<std::size_t>(triangles.size()));
  for (Index t = 0; t < triangles.rows(); ++t) {
    for (Index c = 0; c < 3; ++c) ++lists.start[static_cast<std::size_t>(triangles(t, c)) + 1];
  }
  accumulate(lists.start);
  std::vector<Index> next(lists.start.begin(), lists.start.end() - 1);
  for (Index t = 0; t < triangles.rows(); ++t) {
    for (Index c = 0; c < 3; ++c) {
      lists.items[static_cast<std::size_t>(next[static_cast<std::size_t>(triangles(t, c))]++)] = t;
    }
  }
  return lists;
}

Incidence vertex_graph(Index n_vertices, const Triangles& triangles) {
  const EdgeTable table = edge_table(n_vertices, triangles);
  Incidence lists;
  lists.start.assign(static_cast<std::size_t>(n_vertices) + 1, 0);
  lists.items.resize(static_cast<std::size_t>(table.edges.size()));
  for (Eigen::Index e = 0; e < table.edges.rows(); ++e) {
    for (int side = 0; side < 2; ++side) ++lists.start[static_cast<std::size_t>(table.edges(e, side)) + 1];
  }
  accumulate(lists.start);
  std::vector<Index> next(lists.start.begin(), lists.start.end() - 1);
  // Edges are sorted by (low, high). First all lower neighbours, then all higher ones: each list comes out ascending.
  for (int side = 0; side < 2; ++side) {
    for (Eigen::Index e = 0; e < table.edges.rows(); ++e) {
      const Index vertex = table.edges(e, 1 - side), neighbour = table.edges(e, side);
      lists.items[static_cast<std::size_t>(next[static_cast<std::size_t>(vertex)]++)] = neighbour;
    }
  }
  return lists;
}

}  // namespace loomstone
