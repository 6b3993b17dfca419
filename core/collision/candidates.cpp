#include "core/collision/candidates.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/base/error.h"
#include "core/collision/broad_phase.h"
#include "core/collision/embree_pairs.h"

namespace loomstone {

namespace {

void check(const Points& x0, const Points& x1, const Triangles& triangles, double inflation) {
  std::ostringstream out;
  if (x1.rows() != x0.rows()) {
    out << "x1 must have as many rows as x0 (" << x0.rows() << "), got " << x1.rows();
  } else if (!(inflation >= 0.0) || !std::isfinite(inflation)) {
    out << "inflation must be at least 0 m and finite, got " << inflation;
  } else {
    for (Index i = 0; i < x0.rows() && out.tellp() == 0; ++i)
      if (!x0.row(i).allFinite() || !x1.row(i).allFinite()) out << "positions must be finite, but vertex " << i << " is not";
    for (Index t = 0; t < triangles.rows() && out.tellp() == 0; ++t)
      for (int k = 0; k < 3; ++k)
        if (triangles(t, k) < 0 || triangles(t, k) >= x0.rows()) {
          out << "triangles must hold vertices 0 to " << x0.rows() - 1 << ", but triangle " << t << " has " << triangles(t, k);
          break;
        }
  }
  if (out.tellp() != 0) throw InvalidInput(out.str());
}

Edges unique_edges(const Triangles& triangles) {
  std::vector<std::array<Index, 2>> pairs;
  for (Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles(t, k), b = triangles(t, (k + 1) % 3);
      pairs.push_back({std::min(a, b), std::max(a, b)});
    }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  Edges edges(pairs.size(), 2);
  for (std::size_t e = 0; e < pairs.size(); ++e) edges.row(e) << pairs[e][0], pairs[e][1];
  return edges;
}

// One cloth that collides with itself.
CollisionModel one_surface(Index n_vertices, const Triangles& triangles, const Edges& edges) {
  CollisionModel model;
  model.n_vertices = n_vertices;
  model.triangles = triangles;
  model.edges = edges;
  CollisionSurface surface;
  surface.n_vertices = n_vertices;
  surface.n_triangles = static_cast<Index>(triangles.rows());
  model.surfaces.push_back(surface);
  model.surface_of_vertex.assign(n_vertices, 0);
  model.surface_of_triangle.assign(triangles.rows(), 0);
  model.surface_of_edge.assign(edges.rows(), 0);
  return model;
}

// The definition itself; `pairs_of_boxes(a, b, visit)` names at least all pairs of overlapping boxes.
template <class PairsOfBoxes>
void by_boxes(const Points& x0, const Points& x1, const Triangles& triangles, double inflation, PairsOfBoxes&& pairs_of_boxes,
              Candidates& found) {
  const Edges& edges = found.edges;
  std::vector<Slabs> vertices(x0.rows()), faces(triangles.rows()), segments(edges.rows());
  for (Index i = 0; i < x0.rows(); ++i) vertices[i] = slabs_of(x0.row(i).data(), x1.row(i).data(), inflation);
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
    if ((triangles.row(t).array() != v).all() && overlapping(vertices[v], faces[t])) found.vertex_face.push_back({v, t});
  });
  pairs_of_boxes(segments, segments, [&](Index e, Index f) {
    if (e >= f || edges(e, 0) == edges(f, 0) || edges(e, 0) == edges(f, 1) || edges(e, 1) == edges(f, 0) || edges(e, 1) == edges(f, 1))
      return;
    if (overlapping(segments[e], segments[f])) found.edge_edge.push_back({e, f});
  });
}

}  // namespace

Candidates candidates(const Team& team, const Points& x0, const Points& x1, const Triangles& triangles, double inflation,
                      const std::string& engine) {
  check(x0, x1, triangles, inflation);
  Candidates found;
  found.edges = unique_edges(triangles);
  if (engine == "clusters") {
    const CollisionModel model = one_surface(static_cast<Index>(x0.rows()), triangles, found.edges);
    const std::vector<SurfacePair> pairs = surface_pairs(model);
    BroadPhase broad_phase(model, pairs);
    std::vector<FeaturePairs> keys;
    broad_phase.swept_pairs(team, x0, x1, inflation, {0}, [](ContactKind, PairKey) { return true; }, keys);
    for (const PairKey key : keys[0].vertex_face) found.vertex_face.push_back({first_of(key), second_of(key)});
    for (const PairKey key : keys[0].edge_edge) found.edge_edge.push_back({first_of(key), second_of(key)});
  } else if (engine == "embree") {
    by_boxes(x0, x1, triangles, inflation, [](const auto& a, const auto& b, auto&& visit) { embree_pairs(a, b, visit); }, found);
  } else if (engine == "brute-force") {
    by_boxes(x0, x1, triangles, inflation, [](const auto& a, const auto& b, auto&& visit) {
      for (Index i = 0; i < static_cast<Index>(a.size()); ++i)
        for (Index j = 0; j < static_cast<Index>(b.size()); ++j) visit(i, j);
    }, found);
  } else {
    throw InvalidInput("engine must be \"clusters\", \"embree\" or \"brute-force\", got \"" + engine + "\"");
  }
  std::sort(found.vertex_face.begin(), found.vertex_face.end());
  std::sort(found.edge_edge.begin(), found.edge_edge.end());
  return found;
}

}  // namespace loomstone
