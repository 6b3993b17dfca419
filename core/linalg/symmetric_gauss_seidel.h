// Symmetric block Gauss-Seidel as a preconditioner: z = (S + L)^-T S (S + L)^-1 r. L contains the
// strictly lower blocks of the matrix, without extra terms, and S the diagonal blocks, with extra
// terms. L is stored in single precision, because rounding of a preconditioner does not limit the
// accuracy of the solution. One copy of L serves the forward and the backward sweep. The sweeps are
// sequential.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/linalg/linear_solver.h"
#include "core/linalg/sliced_ellpack.h"

namespace loomstone {

class SymmetricGaussSeidel {
 public:
  // `inverse` (slices x 6 x 8) contains S^-1, with zeros on fixed rows; see pcg_kernels.h.
  void prepare(const LinearSystem& system, const SlicedEllpack& slices,
               const std::vector<float>& inverse);

  // Computes z from r, both stored by slices (slices x 3 x 8). Returns r . z.
  template <class Scalar>
  double apply(const std::vector<Scalar>& r, std::vector<Scalar>& z);

  std::size_t bytes() const {
    return bytes_of(order_, pattern_start_, pattern_columns_, offset_, start_, column_, source_,
                    lower_, inverse_, t_, u_, wide_t_, wide_u_);
  }

 private:
  void order_rows(const LinearSystem& system, const SlicedEllpack& slices);

  // An order of the rows in which a row seldom depends on the row before it, and the pattern for
  // which this order was computed.
  std::vector<Index> order_, pattern_start_, pattern_columns_;
  std::vector<Index> offset_;  // (rows) offset of each row in r and z, in the order of order_
  // start_ (rows + 1) contains the first block of each row, and column_ (blocks of L) the column of
  // each block, both in the order of order_.
  std::vector<Index> start_, column_;
  std::vector<Index> source_;  // (blocks of L) index of each block among those of the matrix
  // Each call of prepare() sets lower_ and inverse_.
  std::vector<float> lower_;    // (9 x blocks of L, padded by 3) entries 00 11 22 01 12 20 02 10 21
  std::vector<float> inverse_;  // (rows x 12) S^-1 in the order of order_
  std::vector<float> t_, u_;    // (rows x 4) scratch memory of apply()
  std::vector<double> wide_t_, wide_u_;
};

}  // namespace loomstone
