// Random trees of tests (NodeTest), on which task pools and traversals are checked. Some branches
// are long and others end at once, as in the traversal of two hierarchies.
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "core/parallel/task_pool.h"

namespace loomstone::testing {

class RandomTree {
 public:
  RandomTree(Index n_roots, Index n_nodes, unsigned seed) : n_roots_(n_roots) {
    std::mt19937 random(seed);
    children_.resize(n_nodes);
    for (Index node = n_roots; node < n_nodes; ++node) {
      // Nodes with small indices are drawn as parents more often, which makes branches uneven.
      const double at = std::uniform_real_distribution<double>(0.0, 1.0)(random);
      children_[static_cast<Index>(at * at * node)].push_back(node);
    }
  }

  Index size() const { return static_cast<Index>(children_.size()); }
  // Returns the roots with which a rank starts: r, r + n_ranks, ... for rank r.
  std::vector<NodeTest> roots(int rank, int n_ranks) const {
    std::vector<NodeTest> tests;
    for (Index root = rank; root < n_roots_; root += n_ranks) tests.push_back(test(root));
    return tests;
  }
  // Appends the tests of the children of `given` to `stack`. Returns the node of `given`.
  Index expand(const NodeTest& given, std::vector<NodeTest>& stack) const {
    for (const Index child : children_[given.node_a]) stack.push_back(test(child));
    return given.node_a;
  }
  // Returns whether the other three indices of a test are those that belong to its node_a.
  static bool intact(const NodeTest& given) {
    const NodeTest made = test(given.node_a);
    return given.node_b == made.node_b && given.hierarchy_a == made.hierarchy_a &&
           given.hierarchy_b == made.hierarchy_b;
  }

 private:
  static NodeTest test(Index node) { return {node % 7, node % 11, node, 3 * node}; }

  Index n_roots_;
  std::vector<std::vector<Index>> children_;
};

}  // namespace loomstone::testing
