// Binary tree of points (k-d tree). A cell with too many points for a leaf is bisected along the
// longest axis of its bounding box, near the median: the number of points in the first half is a
// multiple of eight.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

struct PointCell {
  Vec3 centre;                   // centre of the points' bounding box [m]
  double radius;                 // radius of the bounding sphere about the centre [m]
  Index begin, end;              // range of its points in the order of the tree
  Index children[2] = {-1, -1};  // -1 for a leaf
  int level = 0;

  bool leaf() const { return children[0] < 0; }
};

struct PointTree {
  std::vector<PointCell> cells;  // sorted by level, the root first
  std::vector<Index> order;      // order[i]: row in the input of point i of the tree
  int levels = 0;
};

// Builds the tree of n > 0 points. Leaves contain at most `leaf_size` >= 8 points. In the order of
// the tree, all leaves except the last contain a multiple of eight points.
PointTree make_point_tree(const ConstPointsRef& points, Index leaf_size);

}  // namespace loomstone
