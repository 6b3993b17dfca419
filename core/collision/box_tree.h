// Tree of axis-aligned boxes, eight to a node, over the vertices, edges or triangles of one surface. Items are
// ordered by halving space; a node is eight consecutive nodes below it, so that refitting is a sweep over arrays and a query
// compares a box with eight at once. Boxes are floats rounded outwards. The shape of a tree reaches no result: it only
// decides which boxes are compared.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

inline constexpr int tree_width = 8;

// Eight boxes, component by component. Empty ones have low = +infinity, high = -infinity.
struct alignas(32) BoxGroup {
  float low[3][tree_width];
  float high[3][tree_width];
};

struct Box {
  float low[3];
  float high[3];
};

// Boxes of every vertex over x0 (and x1 where given), grown by `inflation` [m] on each side.
void vertex_boxes(const Team& team, const Points& x0, const Points* x1, Index first, Index count, double inflation,
                  std::vector<Box>& boxes);  // (count)

class BoxTree {
 public:
  // corners (n x corners_per_item): vertices of each item, counted from the surface's first vertex.
  BoxTree(std::vector<Index> corners, int corners_per_item);

  Index n_items() const { return n_items_; }
  Index n_groups() const { return static_cast<Index>(levels_.empty() ? 0 : levels_[0].size()); }
  // Item in lane `lane` of leaf group `group`; -1 in the last group's empty lanes.
  Index item(Index group, int lane) const { return items_[tree_width * group + lane]; }

  // Orders the items anew by their centres.
  void rebuild(const Points& x, Index first_vertex);
  // Boxes of all nodes; returns the summed surface of the leaf groups [m^2], by which decay is judged.
  double refit(const Team& team, const std::vector<Box>& vertices);

  Box root() const;
  Box group_box(Index group) const;
  const BoxGroup& leaf(Index group) const { return levels_[0][group]; }

  // Calls visit(leaf group) for every leaf group >= first_group whose bounding box meets `box`, in ascending order.
  template <class Visit>
  void for_each_group(const Box& box, Index first_group, Visit&& visit) const;

 private:
  Index n_items_;
  int corners_per_item_;
  std::vector<Index> corners_;                  // of each item
  std::vector<Index> items_;                    // (8 * groups)
  std::vector<Index> slot_corners_;             // corners in the order of items_; padding repeats the last item
  std::vector<std::vector<BoxGroup>> levels_;   // 0: items; l: boxes of the groups of level l - 1; the last has one group
};

// Lanes of `group` whose boxes meet `box`, as bits.
inline unsigned overlapping_lanes(const Box& box, const BoxGroup& group) {
  typedef float Floats __attribute__((vector_size(4 * tree_width)));
  typedef std::int32_t Ints __attribute__((vector_size(4 * tree_width)));
  Ints meet{1, 2, 4, 8, 16, 32, 64, 128};
  for (int axis = 0; axis < 3; ++axis) {
    Floats low, high;
    __builtin_memcpy(&low, group.low[axis], sizeof low);
    __builtin_memcpy(&high, group.high[axis], sizeof high);
    meet &= (low <= box.high[axis]) & (high >= box.low[axis]);
  }
  std::uint64_t words[tree_width / 2];
  __builtin_memcpy(words, &meet, sizeof words);
  const std::uint64_t all = words[0] | words[1] | words[2] | words[3];
  return static_cast<unsigned>(all | (all >> 32)) & 0xffu;
}

// For every lane of b the lanes of a, as bits, whose boxes meet it.
void overlapping_lanes(const BoxGroup& a, unsigned lanes_a, const BoxGroup& b, std::int32_t* meeting);

inline bool overlapping(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (a.low[axis] > b.high[axis] || b.low[axis] > a.high[axis]) return false;
  return true;
}

template <class Visit>
void BoxTree::for_each_group(const Box& box, Index first_group, Visit&& visit) const {
  struct Node {
    int level;
    Index group;
  };
  Node stack[tree_width * 12];
  int depth = 0;
  const int top = static_cast<int>(levels_.size()) - 1;
  stack[depth++] = {top, 0};
  while (depth > 0) {
    const Node node = stack[--depth];
    unsigned lanes = overlapping_lanes(box, levels_[node.level][node.group]);
    if (node.level == 1) {
      for (; lanes != 0; lanes &= lanes - 1) {
        const Index group = tree_width * node.group + __builtin_ctz(lanes);
        if (group >= first_group) visit(group);
      }
      continue;
    }
    // Pushed from the last lane down, so that groups come in ascending order.
    for (int lane = tree_width - 1; lane >= 0; --lane) {
      if (!((lanes >> lane) & 1u)) continue;
      const Index child = tree_width * node.group + lane;
      // Leaf groups below `child` end at (child + 1) * 8^(level - 1).
      const std::int64_t end = (static_cast<std::int64_t>(child) + 1) << (3 * (node.level - 1));
      if (end > first_group) stack[depth++] = {node.level - 1, child};
    }
  }
}

}  // namespace loomstone
