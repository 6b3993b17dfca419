// Copy A of a block matrix in single or double precision. A includes the diagonal blocks of bodies,
// but no extra terms (extra_terms.h). Products are computed in difference form, with the row sums
// R_i = sum_j A_ij:
//   (A x)_i = R_i x_i + sum_j A_ij (x_j - x_i).
// Let A = M + h^2 K, with a mass M, a stiffness K and a step h. Then R is M, because K times a
// common translation of all rows is zero. Rounding to single precision must preserve this property.
// In difference form, rounding causes a relative error of 6e-8 in each R_i and each A_ij. In the
// plain product A x, rounding of A would add an error of 6e-8 h^2 |K| to the mass. At h = 4 ms,
// h^2 |K| is about a thousand times the mass (default material, edges of 1 cm).
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "core/base/bytes.h"
#include "core/linalg/sliced_ellpack.h"

namespace loomstone {

template <class Scalar>
class CouplingMatrix {
 public:
  // Allocates the arrays for the slices. set_slices() fills them.
  void resize(const SlicedEllpack& slices);
  // Copies the off-diagonal blocks of the slices [first, last), and computes the sums R of the rows
  // of these slices. `body_blocks` contains the diagonal blocks of the body rows, which follow the
  // rows of the matrix. `matrix` may be null if all rows are body rows, and `body_blocks` may be
  // null if there are no body rows.
  void set_slices(const BlockMatrix* matrix, const std::vector<Mat3>* body_blocks,
                  const SlicedEllpack& slices, Index first, Index last);

  // Computes y = A x for the slices [first, last). Returns x . y over these slices. x has four
  // numbers per row, of which the fourth is zero. After the last row, it has one more row with
  // zeros, for empty lanes. y has the shape (slices x 3 x 8).
  double multiply(const SlicedEllpack& slices, Index first, Index last, const Scalar* x,
                  Scalar* y) const;
  // Computes the same product as multiply(), but stores y by rows, like x.
  void multiply_to_rows(const SlicedEllpack& slices, Index first, Index last, const Scalar* x,
                        Scalar* y) const
    requires std::is_same_v<Scalar, float>;

  std::size_t bytes() const { return bytes_of(values_, sums_, scalar_sum_); }

 private:
  std::vector<Scalar> values_;  // (slots of the slices x 9 x 8) off-diagonal blocks, column-major
  std::vector<Scalar> sums_;    // (slices x 9 x 8) row sums R
  // (slices) 1: all R of the slice are multiples of the identity. Then only the first eight numbers
  // of the slice in sums_ are used, which are the factors of the identity.
  std::vector<std::uint8_t> scalar_sum_;
};

}  // namespace loomstone
