// A copy of a block matrix (with body blocks, without extra terms) in single or double precision,
// multiplied in difference form: with R_i = sum_j A_ij, which is the mass where A is a stiffness
// plus a mass,
//   (A x)_i = R_i x_i + sum_j A_ij (x_j - x_i).
// A stiffness is zero on a common translation, and rounding to single precision has to keep that:
// in difference form each stiffness changes by 6e-8 of itself; in the plain product A x rounding
// would add 6e-8 h^2 |K| to the mass, which is a thousand times smaller than h^2 |K| already at
// h = 4 ms.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "core/linalg/sliced_ellpack.h"

namespace loomstone {

template <class Scalar>
class CouplingMatrix {
 public:
  // Resizes for the slices; set_slices() fills them.
  void resize(const SlicedEllpack& slices);
  // Copies the slices [first, last); body_blocks (may be null): diagonal blocks of the rows that
  // follow the matrix.
  void set_slices(const BlockMatrix* matrix, const std::vector<Mat3>* body_blocks,
                  const SlicedEllpack& slices, Index first, Index last);

  // y = A x for the slices [first, last); returns x . y. x has four numbers a row, the fourth zero,
  // and one row more than the matrix; y (slices x 3 x 8).
  double multiply(const SlicedEllpack& slices, Index first, Index last, const Scalar* x,
                  Scalar* y) const;
  // The same with y by rows, as x is.
  void multiply_to_rows(const SlicedEllpack& slices, Index first, Index last, const Scalar* x,
                        Scalar* y) const
    requires std::is_same_v<Scalar, float>;

 private:
  std::vector<Scalar> values_;  // (slots x 9 x 8) blocks, column-major
  std::vector<Scalar> sums_;    // (slices x 9 x 8) R
  std::vector<std::uint8_t>
      scalar_sum_;  // (slices) 1: R is a number times the identity, the first eight of the slice
};

}  // namespace loomstone
