// Plain binary tree that finds pairs of overlapping boxes. The search for intersections uses it and
// is thus independent of the trees of the broad phase.
#pragma once

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct Box {
  Vec3 low, high;
  bool meets(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

inline std::vector<Box> triangle_boxes(const Points& points, const Triangles& triangles) {
  std::vector<Box> boxes(triangles.rows());
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Vec3 a = points.row(triangles(t, 0)), b = points.row(triangles(t, 1)),
               c = points.row(triangles(t, 2));
    boxes[t] = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
  }
  return boxes;
}

// Binary tree, split at the median along the longest axis. Bounds are exact and need no margin.
class MedianTree {
 public:
  explicit MedianTree(const std::vector<Box>& items) : items_(items), order_(items.size()) {
    std::iota(order_.begin(), order_.end(), Index{0});
    if (!items.empty()) build(0, static_cast<Index>(items.size()));
  }

  template <class Visit>
  void each_pair(Visit&& visit) const {
    if (nodes_.empty()) return;
    std::vector<std::array<Index, 2>> stack{{0, 0}};
    while (!stack.empty()) {
      const auto [a, b] = stack.back();
      stack.pop_back();
      const Node &first = nodes_[a], &second = nodes_[b];
      if (a != b && !first.bounds.meets(second.bounds)) continue;
      const bool leaf_a = first.left < 0, leaf_b = second.left < 0;
      if (leaf_a && leaf_b) {
        leaf_pairs(first, second, a == b, visit);
      } else if (a == b) {
        stack.insert(
            stack.end(),
            {{first.left, first.left}, {first.right, first.right}, {first.left, first.right}});
      } else if (leaf_b || (!leaf_a && first.end - first.begin >= second.end - second.begin)) {
        stack.insert(stack.end(), {{first.left, b}, {first.right, b}});
      } else {
        stack.insert(stack.end(), {{a, second.left}, {a, second.right}});
      }
    }
  }

 private:
  struct Node {
    Box bounds;
    Index begin, end, left = -1, right = -1;
  };

  template <class Visit>
  void leaf_pairs(const Node& first, const Node& second, bool same, Visit&& visit) const {
    for (Index i = first.begin; i < first.end; ++i)
      for (Index j = same ? i + 1 : second.begin; j < second.end; ++j)
        if (items_[order_[i]].meets(items_[order_[j]])) visit(order_[i], order_[j]);
  }

  Index build(Index begin, Index end) {
    const Index node = static_cast<Index>(nodes_.size());
    Box bounds = items_[order_[begin]];
    for (Index i = begin + 1; i < end; ++i) {
      bounds.low = bounds.low.cwiseMin(items_[order_[i]].low);
      bounds.high = bounds.high.cwiseMax(items_[order_[i]].high);
    }
    nodes_.push_back({bounds, begin, end});
    if (end - begin > 4) {
      int axis;
      (bounds.high - bounds.low).maxCoeff(&axis);
      const Index middle = (begin + end) / 2;
      std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                       [&](Index i, Index j) {
                         return items_[i].low[axis] + items_[i].high[axis] <
                                items_[j].low[axis] + items_[j].high[axis];
                       });
      const Index left = build(begin, middle), right = build(middle, end);
      nodes_[node].left = left;
      nodes_[node].right = right;
    }
    return node;
  }

  const std::vector<Box>& items_;
  std::vector<Index> order_;
  std::vector<Node> nodes_;
};

}  // namespace loomstone
