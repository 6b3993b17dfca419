// A copy in single precision of the block matrix of a LinearSystem (body blocks included, extra terms not), kept as
// couplings: with R_i = sum_j A_ij, which is the mass where A is a stiffness plus a mass,
//   (A x)_i = R_i x_i + sum_j A_ij (x_j - x_i).
// A stiffness does not feel a common translation, so its rounding to single precision must not either: as differences it
// changes each stiffness by 6e-8 of itself; as plain A x it would add 6e-8 h^2 |K| to the mass, which is a thousand times
// less than h^2 |K| already at h = 4 ms.
#pragma once

#include <vector>

#include "core/linalg/linear_solver.h"

namespace loomstone {

class SingleMatrix {
 public:
  // Lays out the rows of `system`; set_row() fills them.
  void resize(const LinearSystem& system);
  void set_row(const LinearSystem& system, Index row);

  // Rows of the vectors that multiply() takes: one more than the matrix has. The last is the ground: it is zero.
  Index n_vector_rows() const { return static_cast<Index>(row_start_.size()); }

  // y = A x on rows [begin, end); vectors have 4 floats a row, the fourth is zero.
  void multiply(Index begin, Index end, const float* x, float* y) const;

 private:
  std::vector<Index> row_start_, columns_;
  std::vector<float> values_;  // 9 a block, column-major; 3 more at the end so that a column may be loaded 4 wide
};

}  // namespace loomstone
