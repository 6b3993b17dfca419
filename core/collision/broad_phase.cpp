#include "core/collision/broad_phase.h"

#include <algorithm>
#include <cmath>

#include "core/collision/distance.h"

namespace loomstone {

namespace {

// Leaf groups are dealt out to so many ranges in turn, whatever the number of threads.
constexpr Index n_ranges = 128;
// Leaf boxes of this many times their surface after ordering are ordered anew. Our choice; only speed depends on it.
constexpr double decay_limit = 2.5;

using Kind = CollisionSurface::Kind;

// Are two sets of points surely more than `reach` apart? True only on the evidence of their line of centres.
bool apart_along_centres(const FourPoints& p, int n_a, double reach) {
  Vec3 centre_a = p[0], centre_b = p[n_a];
  for (int i = 1; i < n_a; ++i) centre_a += p[i];
  for (int i = n_a + 1; i < 4; ++i) centre_b += p[i];
  centre_a /= n_a;
  centre_b /= 4 - n_a;
  const Vec3 line = centre_a - centre_b;
  double low = INFINITY, high = -INFINITY;
  for (int i = 0; i < n_a; ++i) low = std::min(low, line.dot(p[i] - centre_b));
  for (int i = n_a; i < 4; ++i) high = std::max(high, line.dot(p[i] - centre_b));
  const double gap = low - high;
  return gap > 0.0 && gap * gap > reach * reach * line.squaredNorm();
}

bool within(ContactKind kind, const FourPoints& p, double reach) {
  if (apart_along_centres(p, kind == ContactKind::VertexFace ? 1 : 2, reach)) return false;
  const ClosestPair closest = kind == ContactKind::VertexFace ? closest_vertex_face(p) : closest_edge_edge(p);
  return closest.distance <= reach;
}

}  // namespace

std::vector<SurfacePair> surface_pairs(const CollisionModel& model) {
  std::vector<SurfacePair> pairs;
  const Index n = static_cast<Index>(model.surfaces.size());
  for (Index a = 0; a < n; ++a)
    for (Index b = a; b < n; ++b) {
      const CollisionSurface &first = model.surfaces[a], &second = model.surfaces[b];
      if (first.kind != Kind::Cloth && second.kind != Kind::Cloth) continue;
      if (a == b && !first.self_collision) continue;
      const bool turned = first.kind != Kind::Cloth;
      pairs.push_back({turned ? b : a, turned ? a : b, 0.5 * (first.thickness + second.thickness),
                       std::sqrt(first.friction * second.friction)});
    }
  return pairs;
}

BroadPhase::BroadPhase(const CollisionModel& model, const std::vector<SurfacePair>& pairs) : model_(model), pairs_(pairs) {
  edges_of_surface_.resize(model.surfaces.size());
  for (Index e = 0; e < model.edges.rows(); ++e) edges_of_surface_[model.surface_of_edge[e]].push_back(e);
  for (std::size_t s = 0; s < model.surfaces.size(); ++s) {
    const CollisionSurface& surface = model.surfaces[s];
    std::vector<Index> vertices(surface.n_vertices), edges, faces;
    for (Index i = 0; i < surface.n_vertices; ++i) vertices[i] = i;
    for (const Index e : edges_of_surface_[s])
      for (int k = 0; k < 2; ++k) edges.push_back(model.edges(e, k) - surface.first_vertex);
    for (Index t = 0; t < surface.n_triangles; ++t)
      for (int k = 0; k < 3; ++k) faces.push_back(model.triangles(surface.first_triangle + t, k) - surface.first_vertex);
    trees_.push_back({BoxTree(std::move(vertices), 1), BoxTree(std::move(edges), 2), BoxTree(std::move(faces), 3)});
  }
}

void BroadPhase::refit(const Team& team, Index s, const Points& x0, const Points* x1, double inflation) {
  SurfaceTrees& trees = trees_[s];
  const CollisionSurface& surface = model_.surfaces[s];
  vertex_boxes(team, x0, x1, surface.first_vertex, surface.n_vertices, inflation, boxes_);
  const auto refit_all = [&] {
    trees.vertices.refit(team, boxes_);
    trees.edges.refit(team, boxes_);
    return trees.faces.refit(team, boxes_);
  };
  double leaf_surface = trees.built ? refit_all() : 0.0;
  if (trees.built && (x1 || leaf_surface <= decay_limit * trees.built_surface)) return;
  trees.vertices.rebuild(x0, surface.first_vertex);
  trees.edges.rebuild(x0, surface.first_vertex);
  trees.faces.rebuild(x0, surface.first_vertex);
  leaf_surface = refit_all();
  trees.built = true;
  trees.built_surface = leaf_surface;
}

bool BroadPhase::excluded(Index pair, ContactKind kind, Index a, Index b) const {
  const bool self = pairs_[pair].a == pairs_[pair].b;
  if (!self && model_.attached_surface.empty()) return false;  // no vertex in common
  const std::array<Index, 4> v = pair_vertices(model_, kind, pair_key(a, b));
  if (self) {
    if (kind == ContactKind::VertexFace) return v[0] == v[1] || v[0] == v[2] || v[0] == v[3];
    return v[0] == v[2] || v[0] == v[3] || v[1] == v[2] || v[1] == v[3];
  }
  const int n_a = kind == ContactKind::VertexFace ? 1 : 2;
  for (int i = 0; i < 4; ++i) {
    const Index other = model_.surface_of_vertex[i < n_a ? v[3] : v[0]];
    if (model_.attached_surface[v[i]] == other) return true;
  }
  return false;
}

template <class KeepPair>
void BroadPhase::collect(const Team& team, const std::vector<Index>& which, KeepPair&& keep,
                         std::vector<FeaturePairs>& found) {
  struct Query {
    Index pair;
    ContactKind kind;
    Index surface_a, surface_b;   // items of a are compared with the tree of b
    const BoxTree *a, *b;
    bool self;
    Index first_group;            // in the numbering of all groups of all queries
  };
  std::vector<Query> queries;
  Index n_groups = 0;
  const auto add = [&](Index pair, ContactKind kind, Index a, Index b) {
    const bool edges = kind == ContactKind::EdgeEdge;
    const BoxTree& first = edges ? trees_[a].edges : trees_[a].vertices;
    const BoxTree& second = edges ? trees_[b].edges : trees_[b].faces;
    if (first.n_items() == 0 || second.n_items() == 0 || !overlapping(first.root(), second.root())) return;
    queries.push_back({pair, kind, a, b, &first, &second, edges && a == b, n_groups});
    n_groups += first.n_groups();
  };
  for (const Index pair : which) {
    const Index a = pairs_[pair].a, b = pairs_[pair].b;
    add(pair, ContactKind::VertexFace, a, b);
    if (a != b) add(pair, ContactKind::VertexFace, b, a);
    add(pair, ContactKind::EdgeEdge, a, b);
  }

  struct Found {
    Index query;
    PairKey key;
  };
  std::vector<std::vector<Found>> of_range(n_ranges);
  const auto search_group = [&](Index q, std::vector<Found>& out) {
    const Query& query = queries[q];
    return [&, q](Index group) {
      query.b->for_each_group(query.a->group_box(group), query.self ? group : 0, [&](Index other) {
        const unsigned own = overlapping_lanes(query.b->group_box(other), query.a->leaf(group));
        if (own == 0) return;
        std::int32_t meeting[tree_width];
        overlapping_lanes(query.a->leaf(group), own, query.b->leaf(other), meeting);
        for (int lane_b = 0; lane_b < tree_width; ++lane_b) {
          unsigned lanes = static_cast<unsigned>(meeting[lane_b]);
          // Within one group each pair once: the lane of a below that of b.
          if (query.self && group == other) lanes &= (1u << lane_b) - 1u;
          for (; lanes != 0; lanes &= lanes - 1) {
            Index a = query.a->item(group, __builtin_ctz(lanes)), b = query.b->item(other, lane_b);
            if (query.kind == ContactKind::EdgeEdge) {
              a = edges_of_surface_[query.surface_a][a];
              b = edges_of_surface_[query.surface_b][b];
              if (b < a) std::swap(a, b);
            } else {
              a += model_.surfaces[query.surface_a].first_vertex;
              b += model_.surfaces[query.surface_b].first_triangle;
            }
            if (!excluded(query.pair, query.kind, a, b) && keep(query.pair, query.kind, a, b))
              out.push_back({q, pair_key(a, b)});
          }
        }
      });
    };
  };
  parallel_ranges(team, n_ranges, 1, [&](Index begin, Index end) {
    for (Index range = begin; range < end; ++range) {
      std::vector<Found>& out = of_range[range];
      Index q = 0;
      for (Index g = range; g < n_groups; g += n_ranges) {
        while (g >= queries[q].first_group + queries[q].a->n_groups()) ++q;
        search_group(q, out)(g - queries[q].first_group);
      }
    }
  });

  for (const Index pair : which) found[pair] = {};
  for (const std::vector<Found>& range : of_range)
    for (const Found& each : range) {
      FeaturePairs& pairs = found[queries[each.query].pair];
      (queries[each.query].kind == ContactKind::VertexFace ? pairs.vertex_face : pairs.edge_edge).push_back(each.key);
    }
  for (const Index pair : which) {
    std::sort(found[pair].vertex_face.begin(), found[pair].vertex_face.end());
    std::sort(found[pair].edge_edge.begin(), found[pair].edge_edge.end());
  }
}

void BroadPhase::near_pairs(const Team& team, const Points& x, const std::vector<Index>& which,
                            const std::vector<double>& reach, std::vector<FeaturePairs>& found) {
  found.resize(pairs_.size());
  // Each surface's boxes grow by half the largest reach it takes part in.
  std::vector<double> inflation(trees_.size(), -1.0);
  for (const Index pair : which)
    for (const Index s : {pairs_[pair].a, pairs_[pair].b}) inflation[s] = std::max(inflation[s], 0.5 * reach[pair]);
  for (std::size_t s = 0; s < trees_.size(); ++s)
    if (inflation[s] >= 0.0) refit(team, static_cast<Index>(s), x, nullptr, inflation[s]);
  collect(
      team, which,
      [&](Index pair, ContactKind kind, Index a, Index b) {
        const std::array<Index, 4> v = pair_vertices(model_, kind, pair_key(a, b));
        FourPoints p;
        for (int i = 0; i < 4; ++i) p[i] = x.row(v[i]).transpose();
        return within(kind, p, reach[pair]);
      },
      found);
}

void BroadPhase::swept_pairs(const Team& team, const Points& x0, const Points& x1, double inflation,
                             const std::vector<Index>& which, const Keep& keep, std::vector<FeaturePairs>& found) {
  found.resize(pairs_.size());
  std::vector<std::uint8_t> needed(trees_.size(), 0);
  for (const Index pair : which) needed[pairs_[pair].a] = needed[pairs_[pair].b] = 1;
  for (std::size_t s = 0; s < trees_.size(); ++s)
    if (needed[s]) refit(team, static_cast<Index>(s), x0, &x1, inflation);
  collect(
      team, which, [&](Index, ContactKind kind, Index a, Index b) { return keep(kind, pair_key(a, b)); }, found);
}

}  // namespace loomstone
