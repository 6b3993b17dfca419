#include "core/magnetics/fast_sums/point_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/simd.h"

namespace loomstone {

PointTree make_point_tree(const ConstPointsRef& points, Index leaf_size) {
  PointTree tree;
  tree.order.resize(points.rows());
  std::iota(tree.order.begin(), tree.order.end(), 0);
  const double* x = points.data();
  std::vector<Index> open;
  const auto add = [&](Index begin, Index end, int level) {
    Vec3 low = points.row(tree.order[begin]).transpose(), high = low;
    for (Index i = begin; i < end; ++i) {
      const Eigen::Map<const Vec3> p(x + 3 * static_cast<std::ptrdiff_t>(tree.order[i]));
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    PointCell cell{0.5 * (low + high), 0.0, begin, end, {-1, -1}, level};
    double square = 0.0;
    for (Index i = begin; i < end; ++i) {
      const Eigen::Map<const Vec3> p(x + 3 * static_cast<std::ptrdiff_t>(tree.order[i]));
      square = std::max(square, (p - cell.centre).squaredNorm());
    }
    cell.radius = std::sqrt(square);
    const Index self = static_cast<Index>(tree.cells.size());
    tree.cells.push_back(cell);
    tree.levels = std::max(tree.levels, level + 1);
    if (end - begin > leaf_size) {
      int axis;
      (high - low).maxCoeff(&axis);
      // The size of the first half is a multiple of eight, so that SIMD lanes are full.
      const Index middle = begin + ((end - begin) / 2 + n_lanes - 1) / n_lanes * n_lanes;
      const auto before = [&](Index a, Index b) {
        const double xa = x[3 * static_cast<std::ptrdiff_t>(a) + axis];
        const double xb = x[3 * static_cast<std::ptrdiff_t>(b) + axis];
        return xa < xb || (xa == xb && a < b);
      };
      std::nth_element(tree.order.begin() + begin, tree.order.begin() + middle,
                       tree.order.begin() + end, before);
      tree.cells[self].children[0] = middle;  // temporarily stores the start of the second half
      open.push_back(self);
    }
  };
  add(0, static_cast<Index>(points.rows()), 0);
  for (std::size_t next = 0; next < open.size(); ++next) {
    const Index parent = open[next];
    const PointCell cell = tree.cells[parent];
    const Index begin = cell.begin, middle = cell.children[0], end = cell.end;
    const int level = cell.level + 1;
    tree.cells[parent].children[0] = static_cast<Index>(tree.cells.size());
    add(begin, middle, level);
    tree.cells[parent].children[1] = static_cast<Index>(tree.cells.size());
    add(middle, end, level);
  }
  return tree;
}

}  // namespace loomstone
