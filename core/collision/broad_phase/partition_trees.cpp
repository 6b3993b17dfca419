#include "core/collision/broad_phase/partition_trees.h"

#include <algorithm>

#include "core/collision/broad_phase/cluster_members.h"

namespace loomstone {

namespace {

// Returns the number of cloth vertices. They are the first vertices of the model.
Index n_cloth_vertices(const CollisionModel& model) {
  Index n = 0;
  for (const CollisionSurface& surface : model.surfaces)
    if (surface.kind == CollisionSurface::Kind::Cloth)
      n = std::max(n, surface.first_vertex + surface.n_vertices);
  return n;
}

// Returns for each vertex the lowest index of a partition that contains one of its triangles, or
// `n_parts` if the vertex has no triangle.
std::vector<Index> part_of_vertices(const CollisionModel& model,
                                    const std::vector<Index>& part_of_triangle, Index n_parts) {
  std::vector<Index> part(model.n_vertices, n_parts);
  for (Index t = 0; t < model.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      Index& of_vertex = part[model.triangles(t, k)];
      of_vertex = std::min(of_vertex, part_of_triangle[t]);
    }
  return part;
}

// Calls visit(first, second) for the sides of a triangle, with the smaller vertex first.
template <class Visit>
void each_side(const Triangles& triangles, Index t, Visit&& visit) {
  for (int k = 0; k < 3; ++k) {
    const Index a = triangles(t, k), b = triangles(t, (k + 1) % 3);
    visit(std::min(a, b), std::max(a, b));
  }
}

// Returns for each edge the lowest index of a partition that contains one of its triangles.
std::vector<Index> part_of_edges(const CollisionModel& model,
                                 const std::vector<Index>& part_of_triangle, Index n_parts) {
  // For each vertex v, the index of the first edge whose smaller vertex is v. Edges are sorted by
  // their smaller vertex.
  std::vector<Index> first_edge(model.n_vertices + 1, 0);
  for (Index e = 0; e < model.edges.rows(); ++e) ++first_edge[model.edges(e, 0) + 1];
  for (Index v = 0; v < model.n_vertices; ++v) first_edge[v + 1] += first_edge[v];
  std::vector<Index> part(model.edges.rows(), n_parts);
  for (Index t = 0; t < model.triangles.rows(); ++t)
    each_side(model.triangles, t, [&](Index a, Index b) {
      Index e = first_edge[a];
      while (model.edges(e, 1) != b) ++e;
      part[e] = std::min(part[e], part_of_triangle[t]);
    });
  return part;
}

}  // namespace

// Partition of each feature.
struct PartitionTrees::PartOf {
  std::vector<Index> triangle, vertex, edge;
};

PartitionTrees::PartitionTrees(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                               int n_parts)
    : model_(model),
      pairs_(pairs),
      surfaces_(model.surfaces.size()),
      pair_of_(surfaces_.size() * surfaces_.size(), -1),
      vertex_boxes_(model.n_vertices) {
  for (std::size_t i = 0; i < pairs.size(); ++i)
    pair_of_[pairs[i].a * surfaces_.size() + pairs[i].b] = static_cast<Index>(i);
  const std::int64_t n_cloth = std::max<Index>(1, n_cloth_vertices(model)), parts = n_parts;
  PartOf part_of;
  part_of.triangle.assign(model.triangles.rows(), 0);
  for (Index t = 0; t < model.triangles.rows(); ++t)
    if (model.surfaces[model.surface_of_triangle(t)].kind == CollisionSurface::Kind::Cloth)
      part_of.triangle[t] = static_cast<Index>(parts * model.triangles(t, 0) / n_cloth);
  part_of.vertex = part_of_vertices(model, part_of.triangle, n_parts);
  part_of.edge = part_of_edges(model, part_of.triangle, n_parts);
  for (std::size_t s = 0; s < surfaces_.size(); ++s)
    divide(static_cast<Index>(s), part_of, n_parts);
}

void PartitionTrees::divide(Index s, const PartOf& part_of, int n_parts) {
  const CollisionSurface& surface = model_.surfaces[s];
  struct Members {
    std::vector<Index> triangles, edges;
  };
  std::vector<Members> members(n_parts);
  for (Index t = surface.first_triangle; t < surface.first_triangle + surface.n_triangles; ++t)
    members[part_of.triangle[t]].triangles.push_back(t);
  for (Index e = 0; e < model_.edges.rows(); ++e)
    if (model_.surface_of_edge(e) == s) members[part_of.edge[e]].edges.push_back(e);
  surfaces_[s].first_part = n_hierarchies();
  for (Index part = 0; part < n_parts; ++part) {
    Members& own = members[part];
    if (own.triangles.empty()) continue;
    std::vector<Index> vertices, foreign;
    for (const Index t : own.triangles)
      for (int k = 0; k < 3; ++k) {
        const Index v = model_.triangles(t, k);
        vertices.push_back(v);
        if (part_of.vertex[v] != part) foreign.push_back(v);
      }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    vertices.shrink_to_fit();
    const std::size_t first_cluster = n_clusters();
    parts_.push_back(
        {s, ClusterTree(model_, std::move(own.triangles), std::move(own.edges), std::move(foreign)),
         first_cluster, std::move(vertices)});
  }
  surfaces_[s].last_part = n_hierarchies();
}

// Sets the vertex boxes of the n vertices that vertex(0) to vertex(n - 1) return.
template <class Vertex>
void PartitionTrees::set_vertex_boxes(const Team& team, const InflatedMotion& motion, Index n,
                                      Vertex&& vertex) {
  parallel_for(
      team, n,
      [&](Index i) {
        const Index v = vertex(i);
        const std::size_t at = 3 * static_cast<std::size_t>(v);
        vertex_boxes_[v] = packed(slabs_of(motion.x0.data() + at, motion.x1.data() + at,
                                           motion.inflation[model_.surface_of_vertex(v)]));
      },
      2048);
}

// Replaces all vertex boxes by those of `vertices`.
void PartitionTrees::find_vertex_boxes(const Team& team, const InflatedMotion& motion,
                                       const std::vector<Index>& vertices) {
  vertex_boxes_.begin();
  vertex_boxes_.add(vertices);
  set_vertex_boxes(team, motion, static_cast<Index>(vertices.size()),
                   [&](Index i) { return vertices[i]; });
}

void PartitionTrees::refit(const Team& team, const InflatedMotion& motion, bool may_rebuild) {
  vertex_boxes_.begin();
  vertex_boxes_.add(0, model_.n_vertices);
  set_vertex_boxes(team, motion, model_.n_vertices, [](Index v) { return v; });
  for (Part& part : parts_)
    part.tree.refit(team, motion.x0, vertex_boxes_, motion.inflation[part.surface], may_rebuild);
  join_roots();
}

void PartitionTrees::refit_nodes(const Team& team, const InflatedMotion& motion, bool may_rebuild) {
  for (Part& part : parts_) {
    find_vertex_boxes(team, motion, part.vertices);
    part.tree.refit_nodes(team, motion.x0, vertex_boxes_, motion.inflation[part.surface],
                          may_rebuild);
  }
  join_roots();
}

void PartitionTrees::refit_features(const Team& team, const InflatedMotion& motion,
                                    const std::vector<NodeTest>& leaves) {
  std::vector<std::vector<std::uint8_t>> marked;  // (hierarchies x clusters)
  for (const Part& part : parts_) marked.emplace_back(part.tree.n_clusters(), 0);
  VertexSet vertices(model_.n_vertices);
  const auto mark = [&](Index hierarchy, Index cluster) {
    if (std::exchange(marked[hierarchy][cluster], 1)) return;
    parts_[hierarchy].tree.each_corner(cluster, [&](Index v) { vertices.add(v); });
  };
  for (const NodeTest& test : leaves) {
    mark(test.hierarchy_a, index_of(test.node_a));
    mark(test.hierarchy_b, index_of(test.node_b));
  }
  find_vertex_boxes(team, motion, vertices.vertices());
  for (Index h = 0; h < n_hierarchies(); ++h)
    parts_[h].tree.refit_features_of(team, marked[h], vertex_boxes_);
}

// Sets the box of each surface.
void PartitionTrees::join_roots() {
  for (Surface& surface : surfaces_) {
    surface.box = empty_slabs();
    for (Index part = surface.first_part; part < surface.last_part; ++part)
      surface.box.include(parts_[part].tree.root());
  }
}

void PartitionTrees::add_root_test(Index a, Index b, std::vector<NodeTest>& tests) const {
  const ClusterTree &first = parts_[a].tree, &second = parts_[b].tree;
  if (overlapping(first.root(), second.root()))
    tests.push_back({a, b, node(first.root_level(), 0), node(second.root_level(), 0)});
}

std::vector<NodeTest> PartitionTrees::top_level(int rank, int n_ranks) const {
  std::vector<NodeTest> tests;
  std::int64_t dealt = 0;  // number of top-level tests that have been assigned to ranks
  // Assigns the next `n` tests to ranks: calls add(i) for each of these tests that belongs to this
  // rank, where i counts the `n` tests from 0.
  const auto deal = [&](Index n, auto&& add) {
    for (std::int64_t i = (rank - dealt % n_ranks + n_ranks) % n_ranks; i < n; i += n_ranks)
      add(static_cast<Index>(i));
    dealt += n;
  };
  for (const SurfacePair& pair : pairs_) {
    const Surface &a = surfaces_[pair.a], &b = surfaces_[pair.b];
    const Index n_a = a.last_part - a.first_part, n_b = b.last_part - b.first_part;
    if (n_a == 0) continue;
    if (pair.a != pair.b) {
      if (overlapping(a.box, b.box))
        for (Index j = 0; j < n_b; ++j)
          deal(n_a, [&](Index i) { add_root_test(a.first_part + i, b.first_part + j, tests); });
      continue;
    }
    // Partition i is compared with partition i + distance, modulo the number of partitions. Each
    // partition thus appears in the same number of tests. each_partner() visits the same tests.
    for (Index distance = 0; distance <= n_a / 2; ++distance)
      deal(2 * distance == n_a && distance > 0 ? distance : n_a, [&](Index i) {
        add_root_test(a.first_part + i, a.first_part + (i + distance) % n_a, tests);
      });
  }
  return tests;
}

std::size_t PartitionTrees::n_clusters() const {
  return parts_.empty() ? 0 : parts_.back().first_cluster + parts_.back().tree.n_clusters();
}

PartitionTrees::Clusters PartitionTrees::clusters_of(const NodeTest& test) const {
  const Part& part = parts_[test.hierarchy_a];
  std::int64_t begin = index_of(test.node_a), n = 1;
  for (int level = level_of(test.node_a); level > 0; --level) begin *= slab_lanes, n *= slab_lanes;
  const auto last = std::min<std::int64_t>(begin + n, part.tree.n_clusters());
  return {part.first_cluster + static_cast<std::size_t>(begin),
          part.first_cluster + static_cast<std::size_t>(last)};
}

// Calls visit(other) for each top-level test whose first hierarchy is `hierarchy`, where `other` is
// the second hierarchy of the test.
template <class Visit>
void PartitionTrees::each_partner(Index hierarchy, Visit&& visit) const {
  const Index s = parts_[hierarchy].surface;
  for (const SurfacePair& pair : pairs_) {
    if (pair.a != s) continue;
    const Surface &a = surfaces_[s], &b = surfaces_[pair.b];
    if (pair.a != pair.b) {
      if (overlapping(a.box, b.box))
        for (Index other = b.first_part; other < b.last_part; ++other) visit(other);
      continue;
    }
    const Index n = a.last_part - a.first_part, own = hierarchy - a.first_part;
    for (Index distance = 0; distance <= n / 2; ++distance)
      if (distance == 0 || 2 * distance != n || own < distance)
        visit(a.first_part + (own + distance) % n);
  }
}

std::vector<NodeTest> PartitionTrees::tests_of(std::size_t begin, std::size_t end) const {
  std::vector<NodeTest> within, across;
  for (Index h = 0; h < n_hierarchies(); ++h) {
    const std::size_t first = parts_[h].first_cluster;
    if (first < end && first + parts_[h].tree.n_clusters() > begin)
      each_partner(h, [&](Index other) { add_root_test(h, other, across); });
  }
  Scratch scratch;
  while (!across.empty()) {
    const NodeTest test = across.back();
    across.pop_back();
    const Clusters clusters = clusters_of(test);
    if (clusters.end <= begin || clusters.begin >= end) continue;
    if (clusters.begin >= begin && clusters.end <= end)
      within.push_back(test);
    else
      expand(test, across, scratch);
  }
  return within;
}

bool PartitionTrees::leaf(const NodeTest& test) {
  return level_of(test.node_a) == 0 && level_of(test.node_b) == 0;
}

void PartitionTrees::expand(const NodeTest& test, std::vector<NodeTest>& stack,
                            Scratch& scratch) const {
  const PairSearch search(parts_[test.hierarchy_a].tree, parts_[test.hierarchy_b].tree);
  const PairSearch::Nodes nodes = {level_of(test.node_a), level_of(test.node_b),
                                   index_of(test.node_a), index_of(test.node_b)};
  scratch.below.clear();
  if (test.hierarchy_a == test.hierarchy_b && test.node_a == test.node_b)
    search.expand(nodes, scratch.below);
  else
    search.expand_larger(nodes, scratch.below);
  for (const PairSearch::Nodes& below : scratch.below)
    stack.push_back({test.hierarchy_a, test.hierarchy_b, node(below.level_a, below.a),
                     node(below.level_b, below.b)});
}

std::size_t PartitionTrees::bytes() const {
  std::size_t sum = bytes_of(vertex_boxes_, pair_of_);
  for (const Part& part : parts_) sum += part.tree.bytes() + bytes_of(part.vertices);
  return sum;
}

}  // namespace loomstone
