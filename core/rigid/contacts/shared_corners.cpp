#include "core/rigid/contacts/shared_corners.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace loomstone {

void SharedCorners::find(const std::vector<std::array<Vec3, 3>>& triangles) {
  const auto point = [&](std::size_t corner) -> const Vec3& {
    return triangles[corner / 3][corner % 3];
  };
  at_corner_.resize(3 * triangles.size());
  std::iota(at_corner_.begin(), at_corner_.end(), std::size_t{0});
  std::sort(at_corner_.begin(), at_corner_.end(), [&](std::size_t a, std::size_t b) {
    const Vec3 &x = point(a), &y = point(b);
    return std::tie(x[0], x[1], x[2], a) < std::tie(y[0], y[1], y[2], b);
  });
  corners_.resize(triangles.size());
  first_.clear();
  for (std::size_t k = 0; k < at_corner_.size(); ++k) {
    const std::size_t corner = at_corner_[k];
    if (k == 0 || point(corner) != point(at_corner_[k - 1])) first_.push_back(k);
    corners_[corner / 3][corner % 3] = first_.size() - 1;
  }
  first_.push_back(at_corner_.size());
  for (std::size_t& entry : at_corner_) entry /= 3;
}

}  // namespace loomstone
