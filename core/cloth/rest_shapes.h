// Rest coordinates of the corners of triangles, and rest positions of vertices. They are either
// stored or computed from the meshes of a scene whenever they are needed. Computing them instead of
// storing them saves 60 bytes per triangle.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"

namespace loomstone {

class RestShapes {
 public:
  using Of = std::function<Corners2(Index triangle)>;
  RestShapes() = default;
  RestShapes(std::vector<Corners2> stored)
      : n_(static_cast<Index>(stored.size())), stored_(std::move(stored)) {}
  // `bytes` is the memory that `computed` holds.
  RestShapes(Index n, Of computed, std::size_t bytes)
      : n_(n), computed_(std::move(computed)), bytes_(bytes) {}

  Index size() const { return n_; }
  Corners2 operator[](Index triangle) const {
    return computed_ ? computed_(triangle) : stored_[triangle];
  }
  // Returns the rest coordinates of the corners of the triangles [first, last) [m].
  std::vector<Corners2> range(Index first, Index last) const {
    if (!computed_) return {stored_.begin() + first, stored_.begin() + last};
    std::vector<Corners2> shapes(last - first);
    for (Index t = first; t < last; ++t) shapes[t - first] = computed_(t);
    return shapes;
  }
  std::vector<Corners2> all() const { return range(0, n_); }
  std::size_t bytes() const { return bytes_ + bytes_of(stored_); }

 private:
  Index n_ = 0;
  std::vector<Corners2> stored_;
  Of computed_;
  std::size_t bytes_ = 0;
};

class RestPositions {
 public:
  RestPositions() = default;
  RestPositions(Points stored) : stored_(std::move(stored)) {}
  // `bytes` is the memory that `computed` holds.
  RestPositions(std::function<Points()> computed, std::size_t bytes)
      : computed_(std::move(computed)), bytes_(bytes) {}

  Points all() const { return computed_ ? computed_() : stored_; }  // (n x 3) [m]
  std::size_t bytes() const { return bytes_ + bytes_of(stored_); }

 private:
  Points stored_;
  std::function<Points()> computed_;
  std::size_t bytes_ = 0;
};

}  // namespace loomstone
