// Bounding-volume hierarchy of one surface, or of a part of it, with up to eight children per node.
// A leaf is a cluster of up to eight neighbouring faces and of the edges and vertices assigned to
// it. Each feature is in one cluster, so each pair of features is visited once. Bounding volumes
// are 18-DOPs, compared eight at a time. The shape of the tree does not affect which pairs are
// found.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/collision/broad_phase/slabs.h"
#include "core/collision/broad_phase/vertex_boxes.h"
#include "core/collision/model/collision_model.h"
#include "core/parallel/shared_work.h"
#include "core/parallel/team.h"

namespace loomstone {

class ClusterTree {
 public:
  // Features of one kind, stored in groups of eight lanes. The groups of cluster c are group[c] to
  // group[c + 1] - 1. The last lanes of a cluster can be empty.
  struct Features {
    std::vector<Index> group;
    std::vector<Index> id;  // (groups x 8) ids in the model; -1 in empty lanes. Empty for vertices
    // Boxes of features, for the clusters that the last refit of features included. The boxes of
    // cluster c begin at slabs[first_slab[c]]. For vertices, `slabs` and `first_slab` are empty.
    std::vector<SlabGroup> slabs;
    std::vector<Index> first_slab;
    int n_corners = 0;
    // (groups x n_corners x 8) Vertex ids; -1 in empty lanes. For vertices, contains all groups.
    // For faces and edges, contains only the groups in `slabs`, in the same order.
    std::vector<Index> corners;
  };

  // The tree of a whole surface. Trees read the triangles and edges of `model`, so `model` must
  // stay alive.
  ClusterTree(const CollisionModel& model, Index surface);
  // The tree of the given triangles and edges of `model`, which are a part of a surface. The tree
  // does not contain the vertices in `foreign`, which belong to the trees of other parts of this
  // surface.
  ClusterTree(const CollisionModel& model, std::vector<Index> triangles, std::vector<Index> edges,
              std::vector<Index> foreign);

  // Recomputes all boxes of the tree. `vertices` contains boxes of at least the vertices of the
  // tree. These boxes include `inflation` [m] and must stay alive until the next refit of features.
  // Forms clusters at positions x if formed() is false, or if `may_rebuild` is set and the boxes of
  // the clusters have grown too much.
  void refit(const Team& team, const Points& x, const VertexBoxes& vertices, double inflation,
             bool may_rebuild);

  void forget() { built_area_ = -1.0; }     // the next refit forms new clusters
  int version() const { return version_; }  // changes whenever new clusters are formed

  // The functions from formed() to set_nodes() refit in stages, so that ranks can divide a refit
  // among themselves. Each rank computes the boxes of some clusters and receives those of the other
  // clusters.
  bool formed() const { return built_area_ >= 0.0; }
  // Forms clusters at x. set_area() must follow.
  void form(const Points& x);
  // Sets the boxes of clusters [begin, end) in `boxes` from vertex boxes. `boxes` has n_slots()
  // entries, and those beyond the last cluster must be empty boxes.
  void find_boxes(const Team& team, const VertexBoxes& vertices, Index begin, Index end,
                  std::vector<PackedSlabs>& boxes) const;
  std::size_t n_slots() const;
  // Stores half the total surface area of the axis-aligned boxes of newly formed clusters, for
  // has_grown(). The given boxes include `inflation` [m], but the area does not.
  void set_area(const std::vector<PackedSlabs>& boxes, double inflation);
  // Returns whether the clusters have grown too much since they were formed (see decay_limit in
  // cluster_tree.cpp). `boxes` contains the boxes of all clusters, which include `inflation` [m].
  bool has_grown(const std::vector<PackedSlabs>& boxes, double inflation) const;
  // Recomputes the boxes of all nodes from those of all clusters.
  void set_nodes(const Team& team, const std::vector<PackedSlabs>& boxes);
  // Like refit(), but recomputes only the boxes of nodes, not those of features.
  void refit_nodes(const Team& team, const Points& x, const VertexBoxes& vertices, double inflation,
                   bool may_rebuild);
  // Recomputes the boxes of marked clusters and of their features, and forgets those of all other
  // clusters. `vertices` has the same meaning as in refit().
  void refit_features_of(const Team& team, const std::vector<std::uint8_t>& marked,
                         const VertexBoxes& vertices);

  // Level 0 contains the clusters. The children of node n on level l are nodes 8 n to 8 n + 7 on
  // level l - 1. The top level has one node.
  int root_level() const { return static_cast<int>(levels_.size()); }
  bool empty() const { return n_clusters_ == 0; }
  const SlabGroup& children(int level, Index node) const { return levels_[level - 1][node]; }
  // Returns the group of boxes that contains the box of `node` in lane node % 8.
  const SlabGroup& boxes(int level, Index node) const {
    return level == root_level() ? root_ : levels_[level][node / slab_lanes];
  }
  Slabs root() const;
  Index n_clusters() const { return n_clusters_; }
  // Returns the box that encloses all features of a cluster. The last refit of features must have
  // included this cluster.
  const PackedSlabs& box(Index cluster) const { return cluster_boxes_[faces_.first_slab[cluster]]; }
  // Returns the vertex boxes that were passed to the last refit of features.
  VertexBoxes::View vertex_boxes() const { return vertex_boxes_->view(); }

  const Features& faces() const { return faces_; }
  const Features& edges() const { return edge_features_; }
  // Vertices are identified by `corners`. Their `id` is empty.
  const Features& vertices() const { return vertices_; }
  // Calls visit(vertex) for the corners of all faces of a cluster.
  template <class Visit>
  void each_corner(Index cluster, Visit&& visit) const {
    for (Index slot = slab_lanes * cluster; slot < slab_lanes * (cluster + 1); ++slot)
      if (const Index id = faces_.id[slot]; id >= 0)
        for (int k = 0; k < 3; ++k) visit(model_->triangles(id, k));
  }
  std::size_t bytes() const;

 private:
  std::vector<Index> clusters_of_faces(const Points& x) const;
  void assign(Features& features, const std::vector<Index>& cluster_of_feature,
              int n_corners) const;
  void find_corners(const Features& features, IndexRange groups, Index* corners) const;
  // Recomputes the boxes of all features, clusters and nodes. Returns those of the clusters.
  std::vector<PackedSlabs> refit_all(const Team& team, const VertexBoxes& vertices);

  void add_levels();
  // Ids of the triangles and edges of the tree.
  Index triangle_id(Index i) const {
    return triangles_.empty() ? first_triangle_ + i : triangles_[i];
  }
  Index edge_id(Index i) const { return triangles_.empty() ? first_edge_ + i : edges_[i]; }

  const CollisionModel* model_;
  // For a whole surface: the smallest ids of its triangles and edges.
  Index first_triangle_ = 0, first_edge_ = 0;
  Index n_triangles_, n_edges_;
  // Arguments of the constructor for a part of a surface; empty for a whole surface.
  std::vector<Index> triangles_, edges_;
  std::vector<Index> foreign_;  // sorted
  Index n_clusters_ = 0;
  bool has_all_corners_ = false;  // true: Features::corners contains all groups of faces and edges
  double built_area_ = -1.0;      // see set_area() [m^2]; negative: not formed
  Features faces_, edge_features_, vertices_;
  std::vector<std::vector<SlabGroup>> levels_;  // node boxes by level
  SlabGroup root_;                              // box of the root in lane 0
  std::vector<PackedSlabs> cluster_boxes_;      // in the order of faces_.slabs
  int version_ = 0;
  const VertexBoxes* vertex_boxes_ = nullptr;
};

}  // namespace loomstone
