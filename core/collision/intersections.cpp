// Pairs of triangles that intersect, by exact predicates; independent of everything else in this module, so that it can
// judge the rest. Pairs that share a vertex are not looked at.

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/collision/collision_stage.h"
#include "core/collision/exact_predicates.h"

namespace loomstone {

namespace {

struct Bounds {
  Vec3 low, high;
  bool meets(const Bounds& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

// Binary tree by halves along the longest axis; bounds are exact, so nothing needs a margin.
class MedianTree {
 public:
  explicit MedianTree(const std::vector<Bounds>& items) : items_(items), order_(items.size()) {
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
        for (Index i = first.begin; i < first.end; ++i)
          for (Index j = a == b ? i + 1 : second.begin; j < second.end; ++j)
            if (items_[order_[i]].meets(items_[order_[j]])) visit(order_[i], order_[j]);
      } else if (a == b) {
        stack.insert(stack.end(), {{first.left, first.left}, {first.right, first.right}, {first.left, first.right}});
      } else if (leaf_b || (!leaf_a && first.end - first.begin >= second.end - second.begin)) {
        stack.insert(stack.end(), {{first.left, b}, {first.right, b}});
      } else {
        stack.insert(stack.end(), {{a, second.left}, {a, second.right}});
      }
    }
  }

 private:
  struct Node {
    Bounds bounds;
    Index begin, end, left = -1, right = -1;
  };

  Index build(Index begin, Index end) {
    const Index node = static_cast<Index>(nodes_.size());
    Bounds bounds = items_[order_[begin]];
    for (Index i = begin + 1; i < end; ++i) {
      bounds.low = bounds.low.cwiseMin(items_[order_[i]].low);
      bounds.high = bounds.high.cwiseMax(items_[order_[i]].high);
    }
    nodes_.push_back({bounds, begin, end});
    if (end - begin > 4) {
      int axis;
      (bounds.high - bounds.low).maxCoeff(&axis);
      const Index middle = (begin + end) / 2;
      std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](Index i, Index j) {
        return items_[i].low[axis] + items_[i].high[axis] < items_[j].low[axis] + items_[j].high[axis];
      });
      const Index left = build(begin, middle), right = build(middle, end);
      nodes_[node].left = left;
      nodes_[node].right = right;
    }
    return node;
  }

  const std::vector<Bounds>& items_;
  std::vector<Index> order_;
  std::vector<Node> nodes_;
};

}  // namespace

std::vector<std::array<Index, 2>> intersecting_pairs(const Points& points, const Triangles& triangles) {
  std::vector<std::array<Vec3, 3>> corners(triangles.rows());
  std::vector<Bounds> bounds(triangles.rows());
  for (Index t = 0; t < triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) corners[t][k] = points.row(triangles(t, k)).transpose();
    bounds[t] = {corners[t][0].cwiseMin(corners[t][1]).cwiseMin(corners[t][2]),
                 corners[t][0].cwiseMax(corners[t][1]).cwiseMax(corners[t][2])};
  }
  std::vector<std::array<Index, 2>> found;
  MedianTree(bounds).each_pair([&](Index i, Index j) {
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
        if (triangles(i, k) == triangles(j, l)) return;
    const auto &a = corners[i], &b = corners[j];
    if (triangles_meet(a[0], a[1], a[2], b[0], b[1], b[2])) found.push_back({std::min(i, j), std::max(i, j)});
  });
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::array<Index, 2>> cloth_intersections(const CollisionModel& model, const Points& points) {
  auto pairs = intersecting_pairs(points, model.triangles);
  std::erase_if(pairs, [&](const std::array<Index, 2>& pair) {
    const Index a = model.surface_of_triangle[pair[0]], b = model.surface_of_triangle[pair[1]];
    const auto cloth = [&](Index s) { return model.surfaces[s].kind == CollisionSurface::Kind::Cloth; };
    return !(cloth(a) || cloth(b)) || (a == b && !model.surfaces[a].self_collision);
  });
  return pairs;
}

}  // namespace loomstone
