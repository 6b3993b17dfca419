// Edges, hinges and incidence lists of a triangle array.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Compressed lists: the items of i are items[start[i] .. start[i+1]), ascending.
struct Incidence {
  std::vector<Index> start;
  std::vector<Index> items;
};

// Unique edges as (smaller, larger) vertex, sorted; an edge's id is its row.
struct EdgeTable {
  Edges edges;                                    // (k x 2)
  std::vector<std::array<Index, 2>> triangles;    // of each edge, ascending; -1: boundary
  std::vector<std::array<Index, 3>> of_triangle;  // edge opposite corner 0, 1, 2 of each triangle
};

// Throws InvalidInput for an edge with more than two triangles and for indices out of range.
EdgeTable edge_table(Index n_vertices, const Triangles& triangles);

// An interior edge with its two triangles, oriented as in [Bridson2003]: triangles (x1,x3,x4) and
// (x2,x4,x3) in their own counter-clockwise order share the edge x3 -> x4.
struct Hinge {
  std::array<Index, 4> vertices;   // x1, x2, x3, x4
  std::array<Index, 2> triangles;  // the one with x1, the one with x2; the first index is smaller
  Index edge;                      // id in the edge table
};

std::vector<Hinge> hinges(const Triangles& triangles, const EdgeTable& edges);

Incidence triangles_of_vertices(Index n_vertices, const Triangles& triangles);
Incidence edges_of_vertices(Index n_vertices, const Edges& edges);
// Neighbours of each vertex: the vertices it shares an edge with.
Incidence vertex_graph(Index n_vertices, const Triangles& triangles);

}  // namespace loomstone
