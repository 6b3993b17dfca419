#include "core/collision/box_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/simd.h"

namespace loomstone {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// Floats below and above x: rounding to nearest errs by half a unit, the factor takes off at least a whole one.
float round_down(double x) {
  const float f = static_cast<float>(x);
  return f - std::abs(f) * 2.4e-7f - 1e-37f;
}
float round_up(double x) {
  const float f = static_cast<float>(x);
  return f + std::abs(f) * 2.4e-7f + 1e-37f;
}

const Box empty_box = {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

void grow(Box& box, const Box& other) {
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = std::min(box.low[axis], other.low[axis]);
    box.high[axis] = std::max(box.high[axis], other.high[axis]);
  }
}

Box box_in_lane(const BoxGroup& group, int lane) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = group.low[axis][lane];
    box.high[axis] = group.high[axis][lane];
  }
  return box;
}

void set_lane(BoxGroup& group, int lane, const Box& box) {
  for (int axis = 0; axis < 3; ++axis) {
    group.low[axis][lane] = box.low[axis];
    group.high[axis][lane] = box.high[axis];
  }
}

Box bounding_box(const BoxGroup& group) {
  Box box = empty_box;
  for (int lane = 0; lane < tree_width; ++lane) grow(box, box_in_lane(group, lane));
  return box;
}

// Orders items so that every node of the tree is compact: halves along the longest axis, cut where a node begins.
void order_by_halves(const Points& centres, Index* items, Index n) {
  if (n <= tree_width) return;
  Eigen::RowVector3d low = centres.row(items[0]), high = low;
  for (Index i = 1; i < n; ++i) {
    low = low.cwiseMin(centres.row(items[i]));
    high = high.cwiseMax(centres.row(items[i]));
  }
  int axis;
  (high - low).maxCoeff(&axis);
  Index node = tree_width;  // items of the largest node that is smaller than all of them
  while (node * tree_width < n) node *= tree_width;
  const Index half = std::max<Index>(1, (n / 2 + node / 2) / node) * node;
  std::nth_element(items, items + half, items + n, [&](Index i, Index j) {
    return centres(i, axis) != centres(j, axis) ? centres(i, axis) < centres(j, axis) : i < j;
  });
  order_by_halves(centres, items, half);
  order_by_halves(centres, items + half, n - half);
}

}  // namespace

LOOMSTONE_CLONES void overlapping_lanes(const BoxGroup& a, unsigned lanes_a, const BoxGroup& b, std::int32_t* meeting) {
  typedef float Floats __attribute__((vector_size(4 * tree_width)));
  typedef std::int32_t Ints __attribute__((vector_size(4 * tree_width)));
  Floats low[3], high[3];
  __builtin_memcpy(low, b.low, sizeof low);
  __builtin_memcpy(high, b.high, sizeof high);
  Ints all{};
  for (; lanes_a != 0; lanes_a &= lanes_a - 1) {
    const int lane = __builtin_ctz(lanes_a);
    Ints meet = (low[0] <= a.high[0][lane]) & (high[0] >= a.low[0][lane]);
    meet &= (low[1] <= a.high[1][lane]) & (high[1] >= a.low[1][lane]);
    meet &= (low[2] <= a.high[2][lane]) & (high[2] >= a.low[2][lane]);
    all |= meet & (1 << lane);
  }
  __builtin_memcpy(meeting, &all, sizeof all);
}

void vertex_boxes(const Team& team, const Points& x0, const Points* x1, Index first, Index count, double inflation,
                  std::vector<Box>& boxes) {
  boxes.resize(count);
  parallel_for(
      team, count,
      [&](Index i) {
        const double* a = x0.data() + 3 * static_cast<std::size_t>(first + i);
        const double* b = x1 ? x1->data() + 3 * static_cast<std::size_t>(first + i) : a;
        for (int axis = 0; axis < 3; ++axis) {
          boxes[i].low[axis] = round_down(std::min(a[axis], b[axis]) - inflation);
          boxes[i].high[axis] = round_up(std::max(a[axis], b[axis]) + inflation);
        }
      },
      4096);
}

BoxTree::BoxTree(std::vector<Index> corners, int corners_per_item)
    : n_items_(static_cast<Index>(corners.size()) / corners_per_item),
      corners_per_item_(corners_per_item),
      corners_(std::move(corners)) {
  Index n = n_items_;
  do {
    n = (n + tree_width - 1) / tree_width;
    BoxGroup empty;
    for (int lane = 0; lane < tree_width; ++lane) set_lane(empty, lane, empty_box);
    levels_.emplace_back(std::max<Index>(n, 1), empty);
  } while (n > 1 || levels_.size() < 2);
  items_.assign(static_cast<std::size_t>(tree_width) * levels_[0].size(), -1);
  slot_corners_.assign(static_cast<std::size_t>(corners_per_item_) * n_items_, 0);
}

void BoxTree::rebuild(const Points& x, Index first_vertex) {
  Points centres(n_items_, 3);
  for (Index i = 0; i < n_items_; ++i) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < corners_per_item_; ++k) sum += x.row(first_vertex + corners_[corners_per_item_ * i + k]).transpose();
    centres.row(i) = (sum / corners_per_item_).transpose();
  }
  for (Index i = 0; i < n_items_; ++i) items_[i] = i;
  order_by_halves(centres, items_.data(), n_items_);
  for (Index slot = 0; slot < n_items_; ++slot)
    for (int k = 0; k < corners_per_item_; ++k)
      slot_corners_[corners_per_item_ * slot + k] = corners_[corners_per_item_ * items_[slot] + k];
}

double BoxTree::refit(const Team& team, const std::vector<Box>& vertices) {
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    std::vector<BoxGroup>& groups = levels_[level];
    const Index n_groups = static_cast<Index>(groups.size());
    const Index n_children = level == 0 ? n_items_ : static_cast<Index>(levels_[level - 1].size());
    parallel_for(
        team, n_groups,
        [&](Index g) {
          for (int lane = 0; lane < tree_width; ++lane) {
            const Index child = tree_width * g + lane;
            Box box = empty_box;
            if (child < n_children) {
              if (level == 0) {
                for (int k = 0; k < corners_per_item_; ++k) grow(box, vertices[slot_corners_[corners_per_item_ * child + k]]);
              } else {
                box = bounding_box(levels_[level - 1][child]);
              }
            }
            set_lane(groups[g], lane, box);
          }
        },
        256);
  }
  double surface = 0.0;
  for (Index g = 0; g < n_groups(); ++g) {
    const Box box = group_box(g);
    if (!(box.low[0] <= box.high[0])) continue;
    const double dx = box.high[0] - box.low[0], dy = box.high[1] - box.low[1], dz = box.high[2] - box.low[2];
    surface += dx * dy + dy * dz + dz * dx;
  }
  return surface;
}

Box BoxTree::root() const { return bounding_box(levels_.back()[0]); }
Box BoxTree::group_box(Index group) const { return box_in_lane(levels_[1][group / tree_width], group % tree_width); }

}  // namespace loomstone
