// Aggregation multigrid for the block matrix of a LinearSystem. A coarse unknown is a common
// translation: of an aggregate of rows on the first level, of a block of rows on the second, of
// four blocks on the third, and so on. The coarse correction is added to the correction by inverse
// diagonal blocks (additive, as in Bramble, Pasciak and Xu, Math. Comp. 55 (1990), with plain
// aggregation). The coarse levels form a V-cycle with one damped Jacobi sweep before and one after
// the coarser levels. The coarsest matrix is factorised. If the V-cycle is replaced by inverse
// diagonal blocks of the aggregates, solves take 1.03 times as long at 14,450 triangles and 1.15
// times at 57,800. The levels use single precision, which suffices for a preconditioner, but the
// coarsest matrix is factorised in double precision. Every rank computes the coarse rows of its own
// rows. All ranks then gather all coarse rows and do the same work.
#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "core/linalg/aggregates.h"
#include "core/linalg/coupling_matrix.h"
#include "core/linalg/linear_solver.h"

namespace loomstone {

class AggregationMultigrid {
 public:
  // Builds the levels for the pattern of `matrix`.
  void set_pattern(const BlockMatrix& matrix);
  // Computes the coarse matrices by summing the blocks of free rows, including those of terms.
  // Rebuilds the levels if terms couple aggregates that neither the matrix nor earlier terms
  // couple. Collective.
  void prepare(const Team& team, const LinearSystem& system);

  // Returns false if a coarse matrix is not positive definite up to rounding. In that case there is
  // no correction.
  bool usable() const { return usable_; }

  // Number of slots of residual and correction. Each aggregate has one slot. Each block has one
  // additional slot for rows without an aggregate (fixed rows, bodies).
  Index n_slots() const { return n_nodes_ + n_blocks_; }
  Index slot(Index row) const { return slot_[row]; }
  Index unused_slot(Index block) const { return n_nodes_ + block; }
  void clear_residual(Index block);
  // (slots x 4) Residual, which the caller sums over the rows of each slot.
  float* residual() { return residual_.data(); }
  // (slots x 4) Correction. The fourth column and the slots without an aggregate are zero.
  const float* correction() const { return correction_.data(); }

  // Computes the correction for the residual. Returns the dot product of residual and correction.
  // Collective.
  double solve(const Team& team, const RowLayout& layout);

 private:
  struct Level {
    BlockMatrix matrix;
    SlicedEllpack slices;             // layout of `matrix`; unused on the coarsest level
    CouplingMatrix<float> couplings;  // copy of `matrix` for the kernels
    // (nodes of the next level + 1) First child on this level of each node of the next level. Empty
    // on the coarsest level.
    std::vector<Index> child_start;
    std::vector<Index> target;  // (blocks) block of the next level that receives each block
    // (nodes x 12) Damped inverse diagonal blocks. Columns are padded to four numbers.
    std::vector<float> inverse;
    // ((nodes + 1) x 4) The last row belongs to the empty lanes of the slices.
    std::vector<float> residual, solution, product;
  };
  void lay_out();
  void add_level(Level& fine, std::vector<Index> child_start);
  void sum_rows(const Team& team, const LinearSystem& system);
  Index first_node(Index row) const;
  void gather_rows(const RowLayout& layout);
  struct TermNodes;
  TermNodes nodes_of(const ExtraTerm& term) const;
  void couple_terms(const LinearSystem& system);
  void add_terms(const LinearSystem& system);
  void sum_level(const Level& fine, Level& coarse) const;
  bool invert_diagonal(Level& level) const;
  void cycle(const Team& team, std::size_t level);

  Aggregates aggregates_;
  Index n_nodes_ = 0, n_blocks_ = 0;
  using Couplings = std::vector<std::pair<Index, Index>>;
  BlockMatrix plain_;  // matrix of the aggregates without terms
  // Pairs (first < second) of aggregates that only terms couple, in ascending order.
  Couplings couplings_;
  std::vector<Index> place_;  // (blocks of plain_) index of each block in the first level
  std::vector<Level> levels_;
  std::vector<Index> target_;  // (blocks of the matrix) block of plain_ that receives each block
  std::vector<Index> slot_;    // (rows) slot of each row
  std::vector<float> residual_, correction_;
  Eigen::LLT<Eigen::MatrixXd> coarsest_;
  bool usable_ = false;
};

}  // namespace loomstone
