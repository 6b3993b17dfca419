// Binary tree of points (k-d tree): each cell is bisected at the median along the longest axis of
// its bounding box, down to small leaves.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

struct PointCell {
  Vec3 centre;                   // of the points' bounding box [m]
  double radius;                 // of the bounding ball about the centre [m]
  Index begin, end;              // its points, in the order of the tree
  Index children[2] = {-1, -1};  // -1, -1: a leaf
  int level = 0;

  bool leaf() const { return children[0] < 0; }
};

struct PointTree {
  std::vector<PointCell> cells;  // level by level, the root first
  std::vector<Index> order;      // row of each point, in the order of the tree
  int levels = 0;
};

// Leaves hold at most `leaf_size` points, in multiples of eight except the last leaf. n > 0.
PointTree make_point_tree(const ConstPointsRef& points, Index leaf_size);

}  // namespace loomstone
