// Boxes of the vertices of a model. Only those vertices that a search needs have a box.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/collision/broad_phase/slabs.h"

namespace loomstone {

class VertexBoxes {
 public:
  explicit VertexBoxes(Index n_vertices) : place_(n_vertices, 0) {}

  // Removes all boxes. Returns a number that identifies the boxes that callers add from now on,
  // until the next call of begin(). Frees the memory if the removed boxes filled less than half of
  // it.
  std::int64_t begin() {
    if (2 * static_cast<std::size_t>(n_) < boxes_.size()) boxes_ = std::vector<PackedSlabs>();
    n_ = 0;
    return ++use_;
  }
  std::int64_t use() const { return use_; }  // result of the last call of begin()

  // Both functions add boxes, whose values are undefined, for vertices that have none. They may
  // move all boxes.
  void add(std::span<const Index> vertices) {
    for (const Index v : vertices) place_[v] = n_++;
    make_room();
  }
  void add(Index first, Index n) {
    for (Index i = 0; i < n; ++i) place_[first + i] = n_++;
    make_room();
  }

  PackedSlabs& operator[](Index vertex) { return boxes_[place_[vertex]]; }

  // View of the boxes for inner loops. Valid until the next call of begin() or add().
  struct View {
    const PackedSlabs* boxes;
    const Index* place;

    const PackedSlabs& operator[](Index vertex) const { return boxes[place[vertex]]; }
  };
  View view() const { return {boxes_.data(), place_.data()}; }

  std::size_t bytes() const { return bytes_of(place_, boxes_); }

 private:
  void make_room() {
    const std::size_t n = n_;
    if (boxes_.capacity() < n) boxes_.reserve(n + n / 16);  // doubling would waste memory
    if (boxes_.size() < n) boxes_.resize(n);
  }

  std::vector<Index> place_;  // (n) index of the box of each vertex that has one
  std::vector<PackedSlabs> boxes_;
  Index n_ = 0;  // number of vertices with a box
  std::int64_t use_ = 0;
};

}  // namespace loomstone
