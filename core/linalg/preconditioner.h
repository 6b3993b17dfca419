// Preconditioners P of conjugate gradients, built from a system and its terms. There are three
// kinds: inverse diagonal blocks (block Jacobi), inverse diagonal blocks plus a correction by
// aggregation multigrid, and symmetric Gauss-Seidel. Vectors r and z are stored by slices, as in
// pcg_kernels.h.
#pragma once

#include <vector>

#include "core/linalg/aggregation_multigrid.h"
#include "core/linalg/linear_solver.h"
#include "core/linalg/pcg_kernels.h"
#include "core/linalg/row_loops.h"
#include "core/linalg/sliced_ellpack.h"
#include "core/linalg/symmetric_gauss_seidel.h"
#include "core/linalg/term_rows.h"

namespace loomstone {

class Preconditioner {
 public:
  enum class Kind { BlockJacobi, Multigrid, GaussSeidel };

  // Discards the multigrid levels. Must be called after the slices have been built for another
  // pattern.
  void forget_pattern() { has_levels_ = false; }
  // Builds the preconditioner. Throws SolverFailure on all ranks if a diagonal block is not
  // positive definite. Collective.
  void make(Kind kind, const RowLoops& loops, const LinearSystem& system, const TermRows& terms,
            const SlicedEllpack& slices);
  // Copies the inverse diagonal blocks to double precision.
  void widen(const RowLoops& loops);

  Kind kind() const { return kind_; }
  // Inverse diagonal blocks (slices x 6 x 8), zero on fixed rows.
  template <class Scalar>
  const Scalar* inverse() const;

  // Returns whether there is a multigrid correction. complete() drops it if a V-cycle is
  // indefinite.
  bool has_correction() const { return uses_levels_; }
  // Returns the correction to add to z, with four numbers per slot, or null if there is none.
  const float* correction() const { return uses_levels_ ? levels_.correction() : nullptr; }
  const Index* slots() const { return slots_.data(); }  // (slices x 8) slots of the correction

  // Sums r over slices [first, last) into the residual of the coarse levels. The slices must form
  // one block of rows.
  template <class Scalar>
  void restrict_residual(Index first, Index last, const std::vector<Scalar>& r) {
    if (!uses_levels_) return;
    levels_.clear_residual(8 * first / rows_per_block);
    pcg::add_up(first, last, slots_.data(), r.data(), levels_.residual());
  }
  // Completes the preconditioned residual and returns r . P^-1 r. On entry, z is r times the
  // inverse diagonal blocks, and `square` is r . z. Gauss-Seidel replaces z. Multigrid computes the
  // correction from the restricted residual and does not change z. Collective.
  template <class Scalar>
  double complete(const RowLoops& loops, double square, const std::vector<Scalar>& r,
                  std::vector<Scalar>& z);

 private:
  void invert_diagonal(const RowLoops& loops, const LinearSystem& system, const TermRows& terms,
                       const SlicedEllpack& slices);
  void make_levels(const RowLoops& loops, const LinearSystem& system, const SlicedEllpack& slices);

  Kind kind_ = Kind::BlockJacobi;
  std::vector<float> inverse_;
  std::vector<double> wide_inverse_;
  SymmetricGaussSeidel gauss_seidel_;
  AggregationMultigrid levels_;
  std::vector<Index> slots_;
  bool has_levels_ = false;  // levels exist for the pattern of the slices
  bool uses_levels_ = false;
};

}  // namespace loomstone
