// Corners that triangles of a surface share. Independent of Bullet.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Numbers the corners of triangles. Corners with bitwise equal coordinates have the same number.
class SharedCorners {
 public:
  void find(const std::vector<std::array<Vec3, 3>>& triangles);
  // Returns the numbers of the corners of triangle t.
  const std::array<std::size_t, 3>& of(std::size_t t) const { return corners_[t]; }
  // Returns the triangles that have the corner with this number.
  std::span<const std::size_t> triangles_at(std::size_t corner) const {
    return {at_corner_.data() + first_[corner], first_[corner + 1] - first_[corner]};
  }

 private:
  std::vector<std::array<std::size_t, 3>> corners_;
  // The triangles at corner c are at_corner_[first_[c]], ..., at_corner_[first_[c + 1] - 1].
  std::vector<std::size_t> first_, at_corner_;
};

}  // namespace loomstone
