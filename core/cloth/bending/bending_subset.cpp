#include "core/cloth/bending/bending_subset.h"

#include <algorithm>
#include <map>

#include "core/base/sort_unique.h"

namespace loomstone {

namespace {

Index place_of(const std::vector<Index>& list, Index item) {
  return static_cast<Index>(std::lower_bound(list.begin(), list.end(), item) - list.begin());
}

std::vector<double> rest_angles(const BendingSetup& whole, const EdgeTable& edges,
                                const BendingSubset& subset) {
  if (whole.rest_angles.empty()) return {};
  std::map<std::pair<Index, Index>, double> of_edge;
  const auto key = [](Index a, Index b) {
    return std::pair<Index, Index>(std::min(a, b), std::max(a, b));
  };
  const std::vector<Hinge> all = hinges(whole.triangles, edges);
  for (std::size_t e = 0; e < all.size(); ++e)
    of_edge[key(all[e].vertices[2], all[e].vertices[3])] = whole.rest_angles[e];
  std::vector<double> angles;
  const auto n = static_cast<Index>(subset.vertices.size());
  for (const Hinge& h : hinges(subset.setup.triangles, edge_table(n, subset.setup.triangles)))
    angles.push_back(
        of_edge.at(key(subset.vertices[h.vertices[2]], subset.vertices[h.vertices[3]])));
  return angles;
}

}  // namespace

void add_neighbours(const EdgeTable& edges, std::vector<Index>& triangles) {
  for (std::size_t i = 0, n = triangles.size(); i < n; ++i)
    for (const Index edge : edges.of_triangle[triangles[i]])
      for (const Index t : edges.triangles[edge])
        if (t >= 0) triangles.push_back(t);
  sort_unique(triangles);
}

BendingOfPart bending_of_part(const BendingSetup& whole, MeshPart part) {
  const Index n = static_cast<Index>(whole.rest_positions.rows());
  const EdgeTable edges = edge_table(n, whole.triangles);
  // A hinge has a vertex in the rows of the part only if one of its two triangles touches these
  // rows. A triangle acts on a hinge only if the hinge is an edge of the triangle or of one of its
  // neighbours.
  std::vector<Index> acting;
  for (Index t = 0; t < whole.triangles.rows(); ++t)
    if (part.contains(whole.triangles, t)) acting.push_back(t);
  add_neighbours(edges, acting);
  add_neighbours(edges, acting);
  BendingSubset subset = bending_subset(whole, edges, acting);
  BendingOfPart made;
  BendingSetup& setup = made.setup = std::move(subset.setup);
  for (Index& vertex : setup.triangles.reshaped()) vertex = subset.vertices[vertex];
  setup.rest_positions = whole.rest_positions;
  setup.prescribed = whole.prescribed;
  setup.forces_only = false;
  // `kept` is the list of the triangles of the setup, made as in bending_subset().
  std::vector<Index> kept = acting;
  add_neighbours(edges, kept);
  add_neighbours(edges, kept);
  made.triangles = {place_of(kept, part.triangles.begin), place_of(kept, part.triangles.end)};
  return made;
}

BendingSubset bending_subset(const BendingSetup& whole, const EdgeTable& edges,
                             const std::vector<Index>& acting) {
  // The curvature of a triangle depends on the angles at the edges of its neighbours, and each of
  // these angles depends on both triangles at its edge.
  std::vector<Index> kept = acting;
  add_neighbours(edges, kept);
  add_neighbours(edges, kept);
  BendingSubset subset;
  for (const Index t : kept)
    for (int k = 0; k < 3; ++k) subset.vertices.push_back(whole.triangles(t, k));
  sort_unique(subset.vertices);
  BendingSetup& setup = subset.setup;
  setup.flat_rest = whole.flat_rest;
  setup.forces_only = true;
  setup.triangles.resize(static_cast<Index>(kept.size()), 3);
  for (const Index t : kept) {
    const auto row = static_cast<Index>(setup.corners.size());
    for (int k = 0; k < 3; ++k)
      setup.triangles(row, k) = place_of(subset.vertices, whole.triangles(t, k));
    setup.corners.push_back(whole.corners[t]);
    setup.rigidity.push_back(whole.rigidity[t]);
    setup.damping.push_back(whole.damping[t]);
    setup.acts.push_back(std::binary_search(acting.begin(), acting.end(), t));
  }
  setup.rest_positions.resize(static_cast<Index>(subset.vertices.size()), 3);
  for (std::size_t i = 0; i < subset.vertices.size(); ++i) {
    setup.rest_positions.row(static_cast<Index>(i)) = whole.rest_positions.row(subset.vertices[i]);
    setup.prescribed.push_back(whole.prescribed[subset.vertices[i]]);
  }
  setup.rest_angles = rest_angles(whole, edges, subset);
  return subset;
}

}  // namespace loomstone
