#include "core/parallel/mesh_part.h"

#include <algorithm>

#include "core/parallel/team.h"

namespace loomstone {

namespace {

Index blocks_of(Index triangles) { return (triangles + rows_per_block - 1) / rows_per_block; }

}  // namespace

std::vector<Index> first_triangles(const Triangles& triangles, const RowLayout& layout) {
  const Index n = static_cast<Index>(triangles.rows());
  // first[rank] is the number of triangles whose vertex with the smallest row belongs to a lower
  // rank.
  std::vector<Index> first(layout.starts().size(), 0);
  for (Index t = 0; t < n; ++t) {
    const Index row = triangles.row(t).minCoeff();
    for (std::size_t rank = 0; rank < first.size(); ++rank)
      first[rank] += row < layout.starts()[rank];
  }
  for (Index& start : first) start = std::min(n, blocks_of(start) * rows_per_block);
  first.back() = n;
  return first;
}

MeshPart part_of_rank(const RowLayout& layout, const std::vector<Index>& first) {
  const int rank = layout.communicator().rank();
  return {{layout.begin(), layout.end()}, {first[rank], first[rank + 1]}};
}

void gather_block_sums(const RowLayout& layout, const std::vector<Index>& first,
                       std::vector<double>& sums) {
  if (layout.single()) return;
  std::vector<std::size_t> offsets;
  for (const Index triangle : first) offsets.push_back(sizeof(double) * blocks_of(triangle));
  layout.communicator().gather_all(sums.data(), offsets);
}

}  // namespace loomstone
