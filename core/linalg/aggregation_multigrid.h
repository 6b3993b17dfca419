// Aggregation multigrid for the block matrix of a LinearSystem. The coarse unknowns are a common
// translation of each aggregate of rows, then of each block of rows, of each four blocks, and so
// on. The correction is added to that of the inverse diagonal blocks (additive, as in Bramble,
// Pasciak and Xu, Math. Comp. 55 (1990), with plain aggregation). Among the coarse levels runs a
// V-cycle with one damped Jacobi sweep before and one after the coarser levels; the coarsest matrix
// is factorised. (The inverse diagonal blocks of the aggregates in place of the V-cycle took 1.03
// times as long at 14,450 triangles, 1.15 at 57,800.) All is in single precision, which is enough
// for a preconditioner, except the factor. Every rank sums the coarse rows of its own rows; then
// all ranks hold all coarse rows and do the same work.
#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "core/linalg/aggregates.h"
#include "core/linalg/coupling_matrix.h"
#include "core/linalg/linear_solver.h"

namespace loomstone {

class AggregationMultigrid {
 public:
  // Lays out the levels for this pattern.
  void set_pattern(const BlockMatrix& matrix);
  // Coarse matrices: sums of the blocks of free rows, terms included. The levels are laid out again
  // where terms couple aggregates that neither the matrix nor earlier terms couple. Collective.
  void prepare(const Team& team, const LinearSystem& system);

  // False where a coarse matrix is not positive definite to rounding: there is no correction.
  bool usable() const { return usable_; }

  // Slots of residual and correction: one an aggregate, then one a block for rows that belong to
  // none (fixed rows, bodies).
  Index n_slots() const { return n_nodes_ + n_blocks_; }
  Index slot(Index row) const { return slot_[row]; }
  Index unused_slot(Index block) const { return n_nodes_ + block; }
  void clear_residual(Index block);
  float* residual() {
    return residual_.data();
  }  // (slots x 4) sums of the residuals of rows, filled by the caller
  const float* correction() const {
    return correction_.data();
  }  // (slots x 4) fourth number and last slots are zero

  // The correction for the residual; returns their product. Collective.
  double solve(const Team& team, const RowLayout& layout);

 private:
  struct Level {
    BlockMatrix matrix;
    SlicedEllpack slices;             // of `matrix`; not at the coarsest
    CouplingMatrix<float> couplings;  // the same matrix as kernels take it
    std::vector<Index>
        child_start;  // (nodes of the next level + 1) nodes of this one; empty at the coarsest
    std::vector<Index> target;   // (blocks) block of the next level that takes it
    std::vector<float> inverse;  // (nodes x 12) damped inverse diagonal blocks, columns of four
    std::vector<float> residual, solution,
        product;  // (nodes + 1, x 4) the last is that of empty lanes
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
  BlockMatrix plain_;         // of the aggregates without terms
  Couplings couplings_;       // of aggregates by terms alone, first < second, ascending
  std::vector<Index> place_;  // (blocks of plain_) block of the first level
  std::vector<Level> levels_;
  std::vector<Index> target_;  // (blocks of the matrix) block of plain_
  std::vector<Index> slot_;    // (rows)
  std::vector<float> residual_, correction_;
  Eigen::LLT<Eigen::MatrixXd> coarsest_;
  bool usable_ = false;
};

}  // namespace loomstone
