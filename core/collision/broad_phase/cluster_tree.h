// Tree over one surface, made for finding pairs of its features quickly: leaves are clusters of
// eight faces that lie close together in space, each with the edges and vertices it owns (every
// feature is owned by one cluster, so every pair is met once), nodes have eight children. Boxes are
// 18-DOPs, compared eight at once. The shape of a tree reaches no result.
#pragma once

#include <vector>

#include "core/collision/broad_phase/slabs.h"
#include "core/parallel/team.h"

namespace loomstone {

class ClusterTree {
 public:
  // Features of one kind in slots of eight to a group; those of cluster c are in groups [group[c],
  // group[c + 1]).
  struct Features {
    std::vector<Index> group;
    std::vector<Index> id;         // (8 * groups), -1 in empty lanes, which follow the others
    std::vector<SlabGroup> slabs;  // none for vertices
    int n_corners = 0;
    std::vector<Index> corners;  // (groups x corners x 8) vertices
  };

  // Triangles and edges of one surface with the vertex ids of all; their own ids count from
  // first_triangle and are edge_ids.
  ClusterTree(Triangles triangles, Index first_triangle, Edges edges, std::vector<Index> edge_ids);

  // All boxes anew, from those of the vertices (of all surfaces), which were grown by `inflation`
  // [m] and stay where they are until the next refit. Clusters are formed at x when they never
  // were, and, if allowed, when their boxes have grown much since.
  void refit(const Team& team, const Points& x, const std::vector<PackedSlabs>& vertices,
             double inflation, bool may_rebuild);

  void forget() { built_area_ = -1.0; }     // clusters are formed anew at the next refit
  int version() const { return version_; }  // another one after clusters were formed anew

  // The boxes of nodes alone, from the boxes of the vertices' motions; clusters are formed at x
  // when they never were, and, if allowed, when their boxes have grown much since, as those of the
  // vertices where they are tell, `still`.
  void refit_nodes(const Team& team, const Points& x, const std::vector<PackedSlabs>& still,
                   const std::vector<PackedSlabs>& moving, bool may_rebuild);
  // The boxes of the features of marked clusters alone, and those around them. `vertices` are used
  // as in refit().
  void refit_features_of(const Team& team, const std::vector<std::uint8_t>& marked,
                         const std::vector<PackedSlabs>& vertices);

  // Nodes of level 0 are clusters; those of level l have the nodes 8 n .. 8 n + 7 of level l - 1
  // below them; one root.
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
  double built_area_ = -1.0;  // summed over the clusters right after they were formed [m^2]
  Features faces_, edge_features_, vertices_;
  std::vector<std::vector<SlabGroup>>
      levels_;                         // of the nodes of each level; the last has one group
  SlabGroup root_;                     // in lane 0
  std::vector<SlabGroup> leaf_boxes_;  // of the clusters
  int version_ = 0;
  const PackedSlabs* vertex_boxes_ = nullptr;
};

}  // namespace loomstone
