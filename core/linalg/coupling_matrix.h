// A copy of a block matrix (body blocks included, extra terms not), in single or double precision,
// kept as couplings: with R_i = sum_j A_ij, which is the mass where A is a stiffness plus a mass,
//   (A x)_i = R_i x_i + sum_j A_ij (x_j - x_i).
// A stiffness does not feel a common translation, so its rounding to single precision must not
// either: as differences it changes each stiffness by 6e-8 of itself; as plain A x it would add
// 6e-8 h^2 |K| to the mass, which is a thousand times less than h^2 |K| already at h = 4 ms.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "core/linalg/row_groups.h"

namespace loomstone {

template <class Scalar>
class CouplingMatrix {
 public:
  // Lays out scratch for the groups; set_groups() fills it.
  void resize(const RowGroups& groups);
  // The groups [first, last); body_blocks (may be null): diagonal blocks of the rows that follow
  // the matrix.
  void set_groups(const BlockMatrix* matrix, const std::vector<Mat3>* body_blocks,
                  const RowGroups& groups, Index first, Index last);

  // y = A x for the groups [first, last); returns x . y. x has four numbers a row, the fourth zero,
  // and one row more than the matrix; y (groups x 3 x 8).
  double multiply(const RowGroups& groups, Index first, Index last, const Scalar* x,
                  Scalar* y) const;
  // The same with y by rows, as x is.
  void multiply_to_rows(const RowGroups& groups, Index first, Index last, const Scalar* x,
                        Scalar* y) const
    requires std::is_same_v<Scalar, float>;

 private:
  std::vector<Scalar> values_;  // (slots x 9 x 8) blocks, column-major
  std::vector<Scalar> sums_;    // (groups x 9 x 8) R
  std::vector<std::uint8_t>
      scalar_sum_;  // (groups) 1: R is a number times the identity, the first eight of the group
};

}  // namespace loomstone
