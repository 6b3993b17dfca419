// Walks two cluster trees, or one with itself, depth first with an explicit stack, and finds exactly the pairs of features
// whose own 18-DOPs overlap and which share no vertex, each once.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/collision/cluster_tree.h"
#include "core/collision/collision_stage.h"

namespace loomstone {

class PairSearch {
 public:
  struct Nodes {
    int level_a, level_b;
    Index a, b;
  };

  PairSearch(const ClusterTree& a, const ClusterTree& b) : a_(&a), b_(&b), self_(&a == &b) {}

  Nodes roots() const { return {a_->root_level(), b_->root_level(), 0, 0}; }
  static bool leaves(const Nodes& nodes) { return nodes.level_a == 0 && nodes.level_b == 0; }
  // Pairs of children that overlap, of the node on the higher level or of both.
  void expand(const Nodes& nodes, std::vector<Nodes>& out) const;

  // Calls visit(kind, a, b) with the ids of vertex and face, or of two edges, for every pair below `start`.
  template <class Visit>
  void run(const Nodes& start, Visit&& visit) const {
    std::vector<Nodes> stack = {start};
    Slots slots;
    while (!stack.empty()) {
      const Nodes nodes = stack.back();
      stack.pop_back();
      if (leaves(nodes))
        leaf_pairs(nodes.a, nodes.b, slots, visit);
      else
        expand(nodes, stack);
    }
  }

 private:
  using Slots = std::vector<std::pair<Index, Index>>;  // of a first and a second feature

  struct Leaf {
    const ClusterTree& tree;
    Index cluster;
    Slabs box;

    Leaf(const ClusterTree& tree, Index cluster) : tree(tree), cluster(cluster), box(tree.box(0, cluster)) {}
  };

  static void vertex_face_slots(const Leaf& a, const Leaf& b, Slots& out);
  static void edge_edge_slots(const Leaf& a, const Leaf& b, bool upper, Slots& out);

  template <class Visit>
  void leaf_pairs(Index a, Index b, Slots& slots, Visit&& visit) const {
    const Leaf leaf_a(*a_, a), leaf_b(*b_, b);
    const bool same = self_ && a == b;
    const auto vertex_face = [&](const Leaf& of_vertices, const Leaf& of_faces) {
      slots.clear();
      vertex_face_slots(of_vertices, of_faces, slots);
      for (const auto& [vertex, face] : slots)
        visit(ContactKind::VertexFace, of_vertices.tree.vertices().corners[vertex], of_faces.tree.faces().id[face]);
    };
    vertex_face(leaf_a, leaf_b);
    if (!same) vertex_face(leaf_b, leaf_a);
    slots.clear();
    edge_edge_slots(leaf_a, leaf_b, same, slots);
    for (const auto& [first, second] : slots) {
      const Index e = a_->edges().id[first], f = b_->edges().id[second];
      visit(ContactKind::EdgeEdge, e < f ? e : f, e < f ? f : e);
    }
  }

  const ClusterTree *a_, *b_;
  bool self_;
};

}  // namespace loomstone
