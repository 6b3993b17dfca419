// Assembles the stiffness K = sum of q_ef u_e u_f^T over pairs of hinges (e, f) into a block
// matrix, row by row. u_e is the gradient of the angle of hinge e, and q_ef is the stiffness that
// couples the angles of e and f [N m].
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/cloth/bending/hinge.h"
#include "core/linalg/block_matrix.h"

namespace loomstone {

// Sparsity pattern of a symmetric matrix over hinges, in compressed-row (CSR) form with ascending
// columns.
struct HingePairs {
  std::vector<Index> start;
  std::vector<Index> hinge;
};

// The matrix to assemble: scale times the sum of q_ef u_e u_f^T over pairs of hinges (e, f).
struct HingeProducts {
  const HingeSet& hinges;
  const HingeValues& values;  // gradients u
  const AlignedDoubles& q;    // one entry per pair [N m]
  double scale;
};

class HingeStiffness {
 public:
  HingeStiffness() = default;
  HingeStiffness(Index n_vertices, const HingeSet& hinges, HingePairs pairs);

  const HingePairs& pairs() const { return pairs_; }
  // Pairs of coupled vertices (i, j) with i < j, in ascending order.
  std::vector<std::pair<Index, Index>> couplings(const HingeSet& hinges) const;

  // Adds the matrix that `products` defines to rows [begin, end) of `matrix`. Hinges are added in
  // ascending order for each block, so the result is bitwise identical for any number of threads
  // and any row range. Block positions are kept until the matrix pattern or the row range changes.
  void add(const Team& team, const HingeProducts& products, Index begin, Index end,
           BlockMatrix& matrix);

  std::size_t bytes() const {
    return bytes_of(pairs_.start, pairs_.hinge, stencil_start_, stencil_, place_, row_blocks_,
                    block_, offset_, chunk_start_, chunk_);
  }

 private:
  void locate(const HingeSet& hinges, const BlockMatrix& matrix, Index begin, Index end);

  HingePairs pairs_;
  Index n_vertices_ = 0;
  // stencil_ lists, for each hinge e, the vertices of all hinges f that are paired with e, in
  // ascending order. place_ contains, for each pair (e, f), the positions of the vertices of f in
  // the stencil of e.
  std::vector<Index> stencil_start_{0}, stencil_;
  std::vector<std::uint8_t> place_;  // (pairs x 4)

  const Index* located_columns_ = nullptr;
  Index located_blocks_ = -1, begin_ = -1, end_ = -1;
  std::vector<std::size_t> row_blocks_;  // (rows of the range + 1) first entry per row in block_
  // For each row, each of its hinges and each vertex of the hinge's stencil, the index of the block
  // within the row.
  std::vector<Index> block_;
  // For each row and each of its hinges, the index of the first moment gradient of the hinge among
  // those of the row's chunk (see chunk_). A hinge has one moment gradient for each vertex of its
  // stencil (see stiffness_kernels.h).
  std::vector<Index> offset_;
  // Start of each chunk of rows in chunk_, and the hinges that touch each chunk, ascending.
  std::vector<Index> chunk_start_, chunk_;
};

}  // namespace loomstone
