#include "core/collision/candidates.h"

#include <algorithm>
#include <utility>

#include "core/base/message.h"
#include "core/collision/broad_phase/embree_pairs.h"
#include "core/collision/broad_phase/slabs.h"
#include "core/collision/detector.h"

namespace loomstone {

namespace {

// Finds candidates directly from their definition in candidates.h, without a ClusterTree.
// `pairs_of_boxes(a, b, visit)` must visit all pairs of overlapping boxes and may visit others.
template <class PairsOfBoxes>
void by_boxes(const Points& x0, const Points& x1, const Triangles& triangles, double inflation,
              PairsOfBoxes&& pairs_of_boxes, Candidates& found) {
  const Edges& edges = found.edges;
  std::vector<Slabs> vertices(x0.rows()), faces(triangles.rows()), segments(edges.rows());
  for (Index i = 0; i < x0.rows(); ++i)
    vertices[i] = slabs_of(x0.row(i).data(), x1.row(i).data(), inflation);
  const auto bound = [&](const auto& rows, std::vector<Slabs>& out) {
    for (Index i = 0; i < rows.rows(); ++i) {
      out[i] = empty_slabs();
      for (const Index v : rows.row(i)) out[i].include(vertices[v]);
    }
  };
  bound(triangles, faces);
  bound(edges, segments);
  std::vector<std::uint8_t> used(x0.rows(), 0);
  for (Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) used[triangles(t, k)] = 1;
  for (Index i = 0; i < x0.rows(); ++i)
    if (!used[i]) vertices[i] = empty_slabs();
  pairs_of_boxes(vertices, faces, [&](Index v, Index t) {
    if ((triangles.row(t).array() != v).all() && overlapping(vertices[v], faces[t]))
      found.vertex_face.push_back({v, t});
  });
  pairs_of_boxes(segments, segments, [&](Index e, Index f) {
    if (e >= f || edges(e, 0) == edges(f, 0) || edges(e, 0) == edges(f, 1) ||
        edges(e, 1) == edges(f, 0) || edges(e, 1) == edges(f, 1))
      return;
    if (overlapping(segments[e], segments[f])) found.edge_edge.push_back({e, f});
  });
}

}  // namespace

Candidates candidates(const Team& team, const Points& x0, const Points& x1,
                      const Triangles& triangles, double inflation, const std::string& engine) {
  check_motion(x0, x1, inflation);
  check_triangles(triangles, static_cast<Index>(x0.rows()));
  Candidates found;
  found.edges = unique_edges(triangles);
  if (engine == "clusters") {
    FeatureIds pairs = Detector(triangles).candidates(team, x0, x1, inflation, true);
    found.vertex_face = std::move(pairs.vertex_face);
    found.edge_edge = std::move(pairs.edge_edge);
    return found;
  } else if (engine == "embree") {
    by_boxes(
        x0, x1, triangles, inflation,
        [](const auto& a, const auto& b, auto&& visit) { embree_pairs(a, b, visit); }, found);
  } else if (engine == "brute-force") {
    by_boxes(
        x0, x1, triangles, inflation,
        [](const auto& a, const auto& b, auto&& visit) {
          for (Index i = 0; i < static_cast<Index>(a.size()); ++i)
            for (Index j = 0; j < static_cast<Index>(b.size()); ++j) visit(i, j);
        },
        found);
  } else {
    fail<InvalidInput>("engine must be \"clusters\", \"embree\" or \"brute-force\", got \"{}\"",
                       engine);
  }
  std::sort(found.vertex_face.begin(), found.vertex_face.end());
  std::sort(found.edge_edge.begin(), found.edge_edge.end());
  return found;
}

}  // namespace loomstone
