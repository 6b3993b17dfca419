// Assembles K = sum over pairs of hinges (e, f) of q_ef u_e u_f^T into a block matrix, row by row.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/cloth/bending/hinge.h"
#include "core/linalg/block_matrix.h"

namespace loomstone {

// Symmetric sparse matrix over hinges, compressed rows, columns ascending.
struct HingePairs {
  std::vector<Index> start;
  std::vector<Index> hinge;
};

// The matrix to assemble: scale sum over pairs of q_ef u_e u_f^T.
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
  // Coupled vertices (i, j), i < j, ascending.
  std::vector<std::pair<Index, Index>> couplings(const HingeSet& hinges) const;

  // Adds the products to rows [begin, end) of `matrix`, hinges ascending for each block: same bits
  // for any team and any row range. Places of blocks are determined once per pattern and range.
  void add(const Team& team, const HingeProducts& products, Index begin, Index end,
           BlockMatrix& matrix);

 private:
  void locate(const HingeSet& hinges, const BlockMatrix& matrix, Index begin, Index end);

  HingePairs pairs_;
  Index n_vertices_ = 0;
  // Stencil of hinge e: the vertices its moment depends on, ascending. place_: where the vertices
  // of each pair's second hinge are in the stencil of its first.
  std::vector<Index> stencil_start_{0}, stencil_;
  std::vector<std::uint8_t> place_;  // (pairs x 4)

  const Index* located_columns_ = nullptr;
  Index located_blocks_ = -1, begin_ = -1, end_ = -1;
  std::vector<std::size_t> row_blocks_;  // (rows of the range + 1) first entry of the row in block_
  // For each vertex in the stencil of each hinge of each row: its block in the row.
  std::vector<Index> block_;
  // For each hinge of each row: first of its moment gradients among its chunk's, in vertices.
  std::vector<Index> offset_;
  std::vector<Index> chunk_start_, chunk_;  // hinges that touch each chunk of rows, ascending
};

}  // namespace loomstone
