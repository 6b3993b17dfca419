// Bounding volume hierarchy of one surface with eight children per node. Leaves are clusters of
// eight neighbouring faces with the edges and vertices they own; each feature has one owner, so
// each pair is visited once. Bounding volumes are 18-DOPs, compared eight at once. The shape of the
// tree affects no result.
#pragma once

#include <vector>

#include "core/collision/broad_phase/slabs.h"
#include "core/parallel/team.h"

namespace loomstone {

class ClusterTree {
 public:
  // Features of one kind in groups of eight slots; cluster c has groups [group[c], group[c + 1]).
  struct Features {
    std::vector<Index> group;
    std::vector<Index> id;         // (8 * groups), -1 in empty lanes, which come last
    std::vector<SlabGroup> slabs;  // empty for vertices
    int n_corners = 0;
    std::vector<Index> corners;  // (groups x corners x 8) vertices
  };

  // Triangles and edges of one surface, with vertex ids of the whole model. Ids of its triangles
  // start at first_triangle, those of its edges are edge_ids.
  ClusterTree(Triangles triangles, Index first_triangle, Edges edges, std::vector<Index> edge_ids);

  // Recomputes all boxes from those of the vertices (of all surfaces), which include `inflation`
  // [m] and must outlive the next refit. Forms the clusters at x the first time and, if allowed,
  // when their boxes have grown much since.
  void refit(const Team& team, const Points& x, const std::vector<PackedSlabs>& vertices,
             double inflation, bool may_rebuild);

  void forget() { built_area_ = -1.0; }     // the next refit forms new clusters
  int version() const { return version_; }  // changes whenever new clusters are formed

  // Recomputes only the boxes of nodes, from boxes around the motions of the vertices. Forms the
  // clusters at x the first time and, if allowed, when their boxes at x have grown much since;
  // `still` are the boxes of the vertices at x.
  void refit_nodes(const Team& team, const Points& x, const std::vector<PackedSlabs>& still,
                   const std::vector<PackedSlabs>& moving, bool may_rebuild);
  // Recomputes only the boxes of marked clusters and of their features. `vertices` as in refit().
  void refit_features_of(const Team& team, const std::vector<std::uint8_t>& marked,
                         const std::vector<PackedSlabs>& vertices);

  // Level 0 holds the clusters; node n of level l has the children 8 n .. 8 n + 7 of level l - 1.
  // The top level has one node.
  int root_level() const { return static_cast<int>(levels_.size()); }
  bool empty() const { return n_clusters_ == 0; }
  const SlabGroup& children(int level, Index node) const { return levels_[level - 1][node]; }
  // The box of a node is lane node % 8 of this.
  const SlabGroup& boxes(int level, Index node) const {
    return level == root_level() ? root_ : levels_[level][node / slab_lanes];
  }
  Slabs root() const;
  Index n_clusters() const { return n_clusters_; }
  // The box around the features of a cluster is lane cluster % 8 of this.
  const SlabGroup& leaf_boxes(Index cluster) const { return leaf_boxes_[cluster / slab_lanes]; }
  const PackedSlabs* vertex_boxes() const {
    return vertex_boxes_;
  }  // of all surfaces, as given to the last refit

  const Features& faces() const { return faces_; }
  const Features& edges() const { return edge_features_; }
  const Features& vertices() const { return vertices_; }  // their ids are their corners
  std::size_t bytes() const;

 private:
  void rebuild(const Points& x);
  void assign(Features& features, const std::vector<Index>& cluster_of_feature, int n_corners,
              const Index* corners) const;
  double refit_all(const Team& team, const std::vector<PackedSlabs>& vertices, double inflation,
                   bool features);

  Triangles triangles_;
  Index first_triangle_;
  Edges edges_;
  std::vector<Index> edge_ids_;
  Index n_clusters_ = 0;
  double built_area_ = -1.0;  // sum over the clusters when they were formed [m^2]
  Features faces_, edge_features_, vertices_;
  std::vector<std::vector<SlabGroup>> levels_;  // nodes of each level; the last has one group
  SlabGroup root_;                              // in lane 0
  std::vector<SlabGroup> leaf_boxes_;           // of the clusters
  int version_ = 0;
  const PackedSlabs* vertex_boxes_ = nullptr;
};

}  // namespace loomstone
