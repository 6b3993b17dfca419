// Division of the elements of a mesh among ranks. A rank stores all elements that touch its rows
// (vertices, see row_layout.h), because they contribute to the forces and to the matrix rows that
// it computes. It also stores the triangles for which it computes energies and the error of a step.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

// The part of a mesh whose elements are stored: all triangles that touch `rows`, and all triangles
// in the range `triangles`.
struct MeshPart {
  IndexRange rows, triangles;

  bool contains(const Triangles& mesh, Index triangle) const {
    return triangles.contains(triangle) || rows.contains(mesh(triangle, 0)) ||
           rows.contains(mesh(triangle, 1)) || rows.contains(mesh(triangle, 2));
  }
};

// Returns the first triangle of each rank, followed by the number of triangles. Ranges that are not
// empty start at multiples of rows_per_block, so that blocks of triangles are summed as on one
// rank. If triangles are sorted by the smallest row of their vertices, most of them touch rows of
// their rank.
std::vector<Index> first_triangles(const Triangles& triangles, const RowLayout& layout);

// Returns the part of this rank. `first` is the result of first_triangles().
MeshPart part_of_rank(const RowLayout& layout, const std::vector<Index>& first);

// Collective. Completes `sums`, which has one entry per block of rows_per_block triangles. Each
// rank contributes the entries for the blocks of its own triangles and receives all others.
void gather_block_sums(const RowLayout& layout, const std::vector<Index>& first,
                       std::vector<double>& sums);

}  // namespace loomstone
