// Edges, hinges and incidence lists of a triangle array.
#pragma once

#include <array>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"

namespace loomstone {

// Compressed lists. List i consists of items[start[i] .. start[i+1]), in ascending order.
struct Incidence {
  std::vector<Index> start;
  std::vector<Index> items;

  std::size_t bytes() const { return bytes_of(start, items); }
};

// Unique edges in sorted order. Each edge is given by its smaller and its larger vertex index. The
// id of an edge is its row.
struct EdgeTable {
  Edges edges;  // (k x 2)
  // Triangles of each edge, in ascending order. On the boundary, the second one is -1.
  std::vector<std::array<Index, 2>> triangles;
  // Edges of each triangle, opposite its corners 0, 1 and 2.
  std::vector<std::array<Index, 3>> of_triangle;

  std::size_t bytes() const { return bytes_of(edges, triangles, of_triangle); }
};

// Builds the edge table. Throws InvalidInput for an edge with more than two triangles and for
// indices out of range.
EdgeTable edge_table(Index n_vertices, const Triangles& triangles);

// An interior edge with its two triangles, oriented as in [Bridson2003]. The triangles (x1, x3, x4)
// and (x2, x4, x3), both in counter-clockwise order, share the edge x3 -> x4.
struct Hinge {
  std::array<Index, 4> vertices;   // x1, x2, x3, x4
  std::array<Index, 2> triangles;  // ids of (x1, x3, x4) and (x2, x4, x3), in ascending order
  Index edge;                      // id in the edge table
};

std::vector<Hinge> hinges(const Triangles& triangles, const EdgeTable& edges);

Incidence triangles_of_vertices(Index n_vertices, const Triangles& triangles);
Incidence edges_of_vertices(Index n_vertices, const Edges& edges);
// Returns the neighbours of each vertex along edges.
Incidence vertex_graph(Index n_vertices, const Triangles& triangles);

}  // namespace loomstone
