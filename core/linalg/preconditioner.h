// Preconditioners P for conjugate gradients, built from a system and its terms. There are three
// kinds of P^-1: inverse diagonal blocks (block Jacobi), inverse diagonal blocks plus a correction
// by aggregation multigrid, and symmetric Gauss-Seidel. The residual r is stored by slices, as in
// pcg_kernels.h, and so is z, which is P^-1 r without the multigrid correction.
#pragma once

#include <vector>

#include "core/base/bytes.h"
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
  struct Rows {
    const TermRows& terms;
    const Halo& halo;  // rows that the matrix and the terms couple to owned rows
    const SlicedEllpack& slices;
  };
  // Builds the preconditioner. Throws StepFailure on all ranks if a diagonal block is not positive
  // definite. Collective.
  void make(Kind kind, const RowLoops& loops, const LinearSystem& system, const Rows& rows);
  // Prepares for double precision: copies the inverse diagonal blocks, and allocates the vectors of
  // the multigrid correction.
  void widen(const RowLoops& loops, const SlicedEllpack& slices);

  Kind kind() const { return kind_; }
  // Inverse diagonal blocks (slices x 6 x 8), zero on fixed rows.
  template <class Scalar>
  const Scalar* inverse() const;

  std::size_t bytes() const {
    return bytes_of(inverse_, wide_inverse_, gauss_seidel_, levels_, slots_);
  }

  // Returns whether there is a multigrid correction. complete() drops it if a V-cycle is
  // indefinite.
  bool has_correction() const { return uses_levels_; }
  // Returns the correction to add to z, with four numbers per slot of AggregationMultigrid, or null
  // if there is none.
  const float* correction() const { return uses_levels_ ? levels_.correction() : nullptr; }
  // (slices x 8) Slot of each lane in correction().
  const Index* slots() const { return slots_.data(); }

  // If there is a multigrid correction, sums the residual r of slices [first, last) into the
  // residual of the coarse levels. The slices must form one block of rows.
  template <class Scalar>
  void restrict_residual(Index first, Index last, const std::vector<Scalar>& r) {
    if (uses_levels_)
      levels_.sum_over_slots(first, last, slots_.data(), r.data(), levels_.vectors<Scalar>().r);
  }
  // Starts to exchange the halo of the residual of the coarse levels. Communicator::finish() and
  // then finish_exchange() must follow. Collective.
  template <class Scalar>
  void start_residual_exchange(const RowLayout& layout) {
    if (uses_levels_) levels_.start_exchange(layout, levels_.vectors<Scalar>().r);
  }
  void finish_exchange() {
    if (uses_levels_) levels_.finish_exchange();
  }
  // Like restrict_residual(), but for the product q = A p.
  template <class Scalar>
  void restrict_product(Index first, Index last, const std::vector<Scalar>& q) {
    if (uses_levels_)
      levels_.sum_over_slots(first, last, slots_.data(), q.data(), levels_.vectors<Scalar>().q);
  }
  // Dot products in a step of conjugate gradients.
  struct StepProducts {
    double curvature;  // p . A p
    double residual;   // r . P^-1 r
  };
  // Returns the dot products of a step, summed over all ranks. `curvature` is p . A p on the owned
  // rows. At the same time, exchanges the halo of the product q on the coarse levels. Collective.
  template <class Scalar>
  StepProducts complete_product(const RowLayout& layout, BinnedSum curvature);
  // Updates the residual of the coarse levels for a step r -= alpha q.
  template <class Scalar>
  void take_step(Scalar alpha) {
    if (uses_levels_) levels_.take_step(alpha);
  }

  // Dot products of the residual r. D contains the diagonal blocks.
  struct Products {
    double diagonal, whole;  // r . D^-1 r and r . P^-1 r
  };
  // Completes the preconditioned residual, and returns the products of r. On entry, z is r times
  // the inverse diagonal blocks, and `square` is r . z on the owned rows. Gauss-Seidel replaces z.
  // Multigrid computes the correction from the residual of the coarse levels and does not change z.
  // It computes Products::whole during the V-cycle, so that no further sum over all ranks is
  // needed. complete_product() then computes r . P^-1 r again, from the correction itself.
  // Collective.
  template <class Scalar>
  Products complete(const RowLoops& loops, BinnedSum square, const std::vector<Scalar>& r,
                    std::vector<Scalar>& z);

 private:
  void invert_diagonal(const RowLoops& loops, const LinearSystem& system, const Rows& rows);
  void make_levels(const RowLoops& loops, const LinearSystem& system, const Rows& rows);

  Kind kind_ = Kind::BlockJacobi;
  std::vector<float> inverse_;
  std::vector<double> wide_inverse_;
  SymmetricGaussSeidel gauss_seidel_;
  AggregationMultigrid levels_;
  std::vector<Index> slots_;
  bool has_levels_ = false;  // levels exist for the pattern of the slices
  bool uses_levels_ = false;
  Products products_{};  // result of the last complete()
};

}  // namespace loomstone
