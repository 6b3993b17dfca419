// Simultaneous traversal of two cluster trees, or of one tree with itself. clusters() visits the
// pairs of clusters whose 18-DOPs overlap, depth-first with an explicit stack. features() visits
// the pairs of features of two clusters that share no vertex and whose 18-DOPs overlap. It can
// first widen one of the two 18-DOPs. Each pair is visited once.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/collision/broad_phase/cluster_tree.h"
#include "core/collision/model/contact.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

class PairSearch {
 public:
  struct Nodes {
    int level_a, level_b;
    Index a, b;
  };

  // Pairs of a vertex id and a face slot, or of two edge slots. A slot is a lane of a group of
  // features: 8 * group + lane.
  using SlotPairs = std::vector<std::pair<Index, Index>>;
  struct Slots {
    // Pairs that features(a, b) finds: a vertex of cluster a and a face of cluster b, a vertex of b
    // and a face of a, an edge of a and an edge of b.
    SlotPairs vertex_face, face_vertex, edge_edge;

    void clear() {
      for (SlotPairs* const pairs : {&vertex_face, &face_vertex, &edge_edge}) pairs->clear();
    }
  };

  PairSearch(const ClusterTree& a, const ClusterTree& b) : a_(&a), b_(&b), self_(&a == &b) {}

  Nodes roots() const { return {a_->root_level(), b_->root_level(), 0, 0}; }
  static bool leaves(const Nodes& nodes) { return nodes.level_a == 0 && nodes.level_b == 0; }
  // Expands the node on the higher level, or both nodes if their levels are equal. Appends the
  // overlapping pairs: of a child and the other node, or of a child of each node.
  void expand(const Nodes& nodes, std::vector<Nodes>& out) const;
  // Like expand(), but expands only one node: the one with the larger volume or, if one node is a
  // cluster, the other one. The nodes must be different, and not both clusters.
  void expand_larger(const Nodes& nodes, std::vector<Nodes>& out) const;

  // Returns whether node a contains a cluster whose index lies in the range `first`.
  static bool meets(const Nodes& nodes, IndexRange first) {
    std::int64_t begin = nodes.a, n = 1;
    for (int level = 0; level < nodes.level_a; ++level) begin *= slab_lanes, n *= slab_lanes;
    return begin < first.end && begin + n > first.begin;
  }

  // Calls visit(a, b) for each pair of overlapping clusters a and b below the two nodes in `start`
  // for which the index a lies in the range `first`.
  template <class Visit>
  void clusters(const Nodes& start, IndexRange first, Visit&& visit) const {
    std::vector<Nodes> stack = {start};
    while (!stack.empty()) {
      const Nodes nodes = stack.back();
      stack.pop_back();
      if (!meets(nodes, first)) continue;
      if (leaves(nodes))
        visit(nodes.a, nodes.b);
      else
        expand(nodes, stack);
    }
  }

  // Calls visit(kind, first, second) for each pair of features of clusters a and b that share no
  // vertex and whose boxes overlap if one of them is widened by `reach` [m]. For a vertex and a
  // face, `first` is the id of the vertex and `second` that of the face. For two edges, `first` is
  // the smaller id. `slots` is scratch memory.
  template <class Visit>
  void features(Index a, Index b, double reach, Slots& slots, Visit&& visit) const {
    slots.clear();
    meeting_slots(a, b, reach, slots);
    for (const auto& [vertex, face] : slots.vertex_face)
      visit(ContactKind::VertexFace, vertex, b_->faces().id[face]);
    for (const auto& [vertex, face] : slots.face_vertex)
      visit(ContactKind::VertexFace, vertex, a_->faces().id[face]);
    for (const auto& [first, second] : slots.edge_edge) {
      const Index e = a_->edges().id[first], f = b_->edges().id[second];
      visit(ContactKind::EdgeEdge, e < f ? e : f, e < f ? f : e);
    }
  }

 private:
  void expand_a(const Nodes& nodes, std::vector<Nodes>& out) const;
  void expand_b(const Nodes& nodes, std::vector<Nodes>& out) const;
  void meeting_slots(Index a, Index b, double reach, Slots& out) const;

  const ClusterTree *a_, *b_;
  bool self_;
};

}  // namespace loomstone
