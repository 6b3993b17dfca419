// Bounding-volume hierarchies of partitions ([Thomaszewski2010], 5.3.1). The sequence of the rows
// of all cloths is cut into ranges of equal length. The triangles of one cloth whose first vertex
// lies in one range form a partition, which is a compact patch with a hierarchy of its own. A body
// or an obstacle has one hierarchy. A vertex or an edge belongs to the first partition that has one
// of its triangles, and to no other. Each pair of features is therefore found once. All ranks store
// all hierarchies, so a test of two nodes is given by four indices.
#pragma once

#include <vector>

#include "core/collision/broad_phase/cluster_tree.h"
#include "core/collision/broad_phase/pair_search.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/feature_pairs.h"
#include "core/parallel/task_pool.h"

namespace loomstone {

// Motion of all vertices, and the inflation of the boxes of each surface [m].
struct InflatedMotion {
  const Points& x0;
  const Points& x1;
  const std::vector<double>& inflation;
};

class PartitionTrees {
 public:
  // Scratch memory of one thread.
  struct Scratch {
    PairSearch::Slots slots;
    std::vector<PairSearch::Nodes> below;
  };

  PartitionTrees(const CollisionModel& model, const std::vector<SurfacePair>& pairs, int n_parts);

  // Recomputes all boxes. The first call builds the hierarchies at motion.x0. If `may_rebuild` is
  // set, a later call builds a hierarchy again if its boxes have grown too much.
  void refit(const Team& team, const InflatedMotion& motion, bool may_rebuild);
  // Called in this order, the next two functions do the same as refit(), but omit the boxes of
  // features that `leaves` do not compare. `leaves` are tests of two clusters.
  void refit_nodes(const Team& team, const InflatedMotion& motion, bool may_rebuild);
  void refit_features(const Team& team, const InflatedMotion& motion,
                      const std::vector<NodeTest>& leaves);

  // Top-level tests compare each partition with itself, with each other partition, and with each
  // body or obstacle, if their surfaces may collide and the boxes of these surfaces overlap. Test i
  // belongs to rank i modulo `n_ranks`. Returns those tests of a rank whose nodes have overlapping
  // boxes.
  std::vector<NodeTest> top_level(int rank, int n_ranks) const;

  // Returns the number of clusters of all hierarchies. Cluster indices follow the order of the
  // hierarchies.
  std::size_t n_clusters() const;
  // Returns the lowest index of a cluster in node a of a test.
  std::size_t first_cluster(const NodeTest& test) const { return clusters_of(test).begin; }
  // Returns tests in which node a contains only clusters with the indices `begin` to `end` - 1. For
  // these clusters, the returned tests replace the top-level tests. A top-level test in which node
  // a also contains other clusters is expanded.
  std::vector<NodeTest> tests_of(std::size_t begin, std::size_t end) const;

  // Returns whether a test compares two clusters, which have features instead of children.
  static bool leaf(const NodeTest& test);
  // Expands both nodes of a test if they are the same node, otherwise one of them; see
  // PairSearch::expand_larger(). Appends the tests of the pairs of nodes that overlap.
  void expand(const NodeTest& test, std::vector<NodeTest>& stack, Scratch& scratch) const;
  // Calls visit(surface pair, kind, key) for the pairs of features with overlapping boxes in the
  // two clusters of a test. Omits pairs that share a vertex.
  template <class Visit>
  void features(const NodeTest& test, Scratch& scratch, Visit&& visit) const {
    const Part &a = parts_[test.hierarchy_a], &b = parts_[test.hierarchy_b];
    const Index pair = surface_pair(a, b);
    PairSearch(a.tree, b.tree)
        .features(index_of(test.node_a), index_of(test.node_b), 0.0, scratch.slots,
                  [&](ContactKind kind, Index first, Index second) {
                    visit(pair, kind, pair_key(first, second));
                  });
  }

  Index n_hierarchies() const { return static_cast<Index>(parts_.size()); }
  std::size_t bytes() const;

 private:
  struct Part {
    Index surface;
    ClusterTree tree;
    std::size_t first_cluster;    // index of its first cluster
    std::vector<Index> vertices;  // in ascending order
  };
  // The hierarchies of a surface are those with the indices first_part to last_part - 1.
  struct Surface {
    Index first_part = 0, last_part = 0;
    Slabs box;  // box around all hierarchies of the surface
  };

  // A node is stored as one number: its level, followed by its index on this level in the lowest
  // index_bits bits.
  static constexpr int index_bits = 27;
  static Index node(int level, Index index) { return level << index_bits | index; }
  static int level_of(Index node) { return node >> index_bits; }
  static Index index_of(Index node) { return node & ((1 << index_bits) - 1); }

  // Range [begin, end) of cluster indices.
  struct Clusters {
    std::size_t begin, end;
  };
  Clusters clusters_of(const NodeTest& test) const;
  template <class Visit>
  void each_partner(Index hierarchy, Visit&& visit) const;

  struct PartOf;
  void divide(Index surface, const PartOf& part_of, int n_parts);
  Index surface_pair(const Part& a, const Part& b) const {
    return pair_of_[a.surface * surfaces_.size() + b.surface];
  }
  void join_roots();
  template <class Vertex>
  void set_vertex_boxes(const Team& team, const InflatedMotion& motion, Index n, Vertex&& vertex);
  void find_vertex_boxes(const Team& team, const InflatedMotion& motion,
                         const std::vector<Index>& vertices);
  void add_root_test(Index a, Index b, std::vector<NodeTest>& tests) const;

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  std::vector<Part> parts_;
  std::vector<Surface> surfaces_;
  // (surfaces x surfaces) Index in pairs_ of a pair of surfaces; -1 if it is not in pairs_.
  std::vector<Index> pair_of_;
  VertexBoxes vertex_boxes_;
};

}  // namespace loomstone
