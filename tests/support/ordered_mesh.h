// A mesh in the vertex order of a simulation, in which neighbouring vertices have nearby rows.
#pragma once

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/mesh/adjacency.h"
#include "core/mesh/triangle_mesh.h"
#include "core/parallel/vertex_order.h"

namespace loomstone::test {

// Returns the mesh with its vertices ordered by graph bisection, and its triangles by the smallest
// new index of their vertices. Replaces the vertex indices in `marked` by the new ones.
inline TriangleMesh ordered(const TriangleMesh& mesh, std::vector<Index>& marked) {
  const Incidence neighbours = vertex_graph(mesh.n_vertices(), mesh.triangles());
  const std::vector<Index> order = bisection_order({neighbours.start, neighbours.items});
  std::vector<Index> row(order.size());
  Points x(mesh.n_vertices(), 3);
  for (Index i = 0; i < mesh.n_vertices(); ++i)
    row[order[i]] = i, x.row(i) = mesh.vertices().row(order[i]);
  for (Index& vertex : marked) vertex = row[vertex];
  std::vector<Index> sorted(mesh.n_triangles());
  std::iota(sorted.begin(), sorted.end(), 0);
  const auto first = [&](Index t) {
    const auto corner = mesh.triangles().row(t);
    return std::min({row[corner[0]], row[corner[1]], row[corner[2]]});
  };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](Index a, Index b) { return first(a) < first(b); });
  Triangles triangles(mesh.n_triangles(), 3);
  for (Index t = 0; t < mesh.n_triangles(); ++t)
    for (int k = 0; k < 3; ++k) triangles(t, k) = row[mesh.triangles()(sorted[t], k)];
  return {std::move(x), std::move(triangles)};
}

}  // namespace loomstone::test
