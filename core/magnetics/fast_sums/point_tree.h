// Binary tree of points: boxes halved along their longest axis between equally many points, down to
// leaves of a few.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

struct PointCell {
  Vec3 centre;                   // of the points' bounding box [m]
  double radius;                 // of the ball about it that holds the points [m]
  Index begin, end;              // its points in the order of the tree
  Index children[2] = {-1, -1};  // -1, -1: a leaf
  int level = 0;

  bool leaf() const { return children[0] < 0; }
};

struct PointTree {
  std::vector<PointCell> cells;  // parents come before their children, the root first
  std::vector<Index> order;      // row of each point of the tree
  int levels = 0;
};

// Leaves hold at most `leaf_size` points, a multiple of eight but for the last of all. n > 0.
PointTree make_point_tree(const ConstPointsRef& points, Index leaf_size);

}  // namespace loomstone
