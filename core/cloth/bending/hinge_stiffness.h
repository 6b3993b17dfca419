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

class HingeStiffness {
 public:
  HingeStiffness() = default;
  HingeStiffness(Index n_vertices, const HingeSet& hinges, HingePairs pairs);

  const HingePairs& pairs() const { return pairs_; }
  std::vector<std::pair<Index, Index>> couplings(
      const HingeSet& hinges) const;  // (i, j), i < j, ascending

  // Adds scale times K to rows [begin, end) of `matrix`; q: one entry a pair. Hinges ascending for
  // each block: same bits for any team and any row range. Where blocks lie is found once per
  // pattern and range.
  void add(const Team& team, const HingeSet& hinges, const HingeValues& values,
           const AlignedDoubles& q, double scale, Index begin, Index end, BlockMatrix& matrix);

 private:
  void locate(const HingeSet& hinges, const BlockMatrix& matrix, Index begin, Index end);

  HingePairs pairs_;
  Index n_vertices_ = 0;
  // Stencil of hinge e: vertices its moment depends on, ascending; place: those of each pair's
  // second hinge in it.
  std::vector<Index> stencil_start_{0}, stencil_;
  std::vector<std::uint8_t> place_;  // (pairs x 4)

  const Index* located_columns_ = nullptr;
  Index located_blocks_ = -1, begin_ = -1, end_ = -1;
  std::vector<std::size_t> row_blocks_;  // (rows of the range + 1) first entry of the row in block_
  std::vector<Index>
      block_;  // of each vertex of the stencil of each hinge of the row: block in the row
  std::vector<Index>
      offset_;  // of each hinge of each row: where its moments lie in its chunk's, in vertices
  std::vector<Index> chunk_start_, chunk_;  // hinges that touch each chunk of rows, ascending
};

}  // namespace loomstone
