// Symmetric block Gauss-Seidel as a preconditioner: z = (S + L)^-T S (S + L)^-1 r with L the
// strictly lower blocks of the matrix and S the diagonal blocks, extra terms included. Rounding in
// it changes only the number of iterations, so L is stored in single precision, once for both
// sweeps. Sequential.
#pragma once

#include <vector>

#include "core/linalg/linear_solver.h"
#include "core/linalg/sliced_ellpack.h"

namespace loomstone {

class SymmetricGaussSeidel {
 public:
  // inverse (slices x 6 x 8): S^-1, zero on fixed rows; see pcg_kernels.h.
  void prepare(const LinearSystem& system, const SlicedEllpack& slices,
               const std::vector<float>& inverse);

  // z from r, both by slices (slices x 3 x 8); returns r . z.
  template <class Scalar>
  double apply(const std::vector<Scalar>& r, std::vector<Scalar>& z);

 private:
  void order_rows(const LinearSystem& system, const SlicedEllpack& slices);

  // Order of the rows in which a row seldom depends on the one just before it; kept while the
  // pattern stays.
  std::vector<Index> order_, pattern_start_, pattern_columns_;
  std::vector<Index> offset_;          // (rows) of each place of the order: its row in r and z
  std::vector<Index> start_, column_;  // (rows + 1) by place; (blocks of L)
  std::vector<Index> source_;          // (blocks of L) block of the matrix
  // Scratch of one solve.
  std::vector<float> lower_;    // (blocks of L x 9) 00 11 22 01 12 20 02 10 21; 3 more at the end
  std::vector<float> inverse_;  // (rows x 12) by place
  std::vector<float> t_, u_;    // (rows x 4)
  std::vector<double> wide_t_, wide_u_;
};

}  // namespace loomstone
