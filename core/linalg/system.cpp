#include "core/linalg/system.h"

#include <algorithm>

#include "core/base/message.h"

namespace loomstone {

OwnedBlocks owned_blocks(const RowLayout& layout) {
  if (layout.begin() == layout.end()) return {};
  return {layout.begin() / rows_per_block, (layout.end() + rows_per_block - 1) / rows_per_block};
}

void check_system(const LinearSystem& system, const RowsIn& b, const Points& x) {
  const Index rows = system.layout->n_rows();
  const Index bodies = system.body_blocks ? static_cast<Index>(system.body_blocks->size()) : 0;
  const auto require = [&](const char* what, Eigen::Index got) {
    if (got != rows)
      fail<InvalidInput>(
          "linear system: {} must have one row for each of the {} rows of the layout, got {}", what,
          rows, got);
  };
  require("matrix and body_blocks together", n_cloth_rows(system) + bodies);
  if (b.begin() > system.layout->begin() || b.end() < system.layout->end())
    fail<InvalidInput>(
        "linear system: b must have one row for each of the {} rows of this rank, got {}",
        system.layout->end() - system.layout->begin(), b.end() - b.begin());
  require("x", x.rows());
  if (system.fixed) require("fixed", static_cast<Eigen::Index>(system.fixed->size()));
}

Mat3 diagonal_block(const LinearSystem& system, const TermRows& terms, Index row) {
  const Index n_cloth = n_cloth_rows(system);
  Mat3 block = row < n_cloth ? Mat3(system.matrix->block_map(system.matrix->diagonal()[row]))
                             : (*system.body_blocks)[row - n_cloth];
  if (terms.touches(row)) block += terms.diagonal(row);
  return block;
}

void multiply_system(const LinearSystem& system, const TermRows& terms, Index begin, Index end,
                     const double* x, double* y) {
  const Index n_cloth = n_cloth_rows(system);
  if (begin < n_cloth) system.matrix->multiply(begin, std::min(end, n_cloth), x, y);
  for (Index row = std::max(begin, n_cloth); row < end; ++row) {
    Eigen::Map<Vec4> out(y + 4 * static_cast<std::size_t>(row - begin));
    out.head<3>().noalias() = (*system.body_blocks)[row - n_cloth] *
                              Eigen::Map<const Vec3>(x + 4 * static_cast<std::size_t>(row));
    out[3] = 0.0;
  }
  if (terms.empty()) return;
  for (Index row = begin; row < end; ++row)
    if (terms.touches(row))
      Eigen::Map<Vec3>(y + 4 * static_cast<std::size_t>(row - begin)) += terms.force(row);
}

void throw_not_finite(const LinearSystem& system, const RowsIn& b, const Points& x) {
  const RowLayout& layout = *system.layout;
  Index bad = layout.n_rows();
  for (Index row = layout.begin(); row < layout.end() && bad == layout.n_rows(); ++row)
    if (!b.row(row).allFinite() || !x.row(row).allFinite()) bad = row;
  const auto first =
      static_cast<Index>(-layout.communicator().maximum(-static_cast<std::int64_t>(bad)));
  if (first == layout.n_rows())
    throw StepFailure(
        "linear solve: the matrix must be finite, got a product with NaN or infinity; check the "
        "forces and the step size");
  fail<SolverFailure>(
      "linear solve: right side and guess must be finite, got NaN or infinity in row {}; check the "
      "forces on it and the step size",
      first);
}

void refuse_indefinite_row(const LinearSystem& system, Index bad_row) {
  const Index none = system.layout->n_rows();
  const std::int64_t mine = bad_row < 0 ? none : bad_row;
  const auto first = static_cast<Index>(-system.layout->communicator().maximum(-mine));
  if (first < none)
    fail<StepFailure>(
        "linear solve: the matrix must be positive definite, got a diagonal block in row {} "
        "that is not; check the mass of this row and reduce the step size",
        first);
}

void throw_indefinite(const char* method, int iteration) {
  fail<StepFailure>(
      "linear solve: the matrix must be positive definite, got a direction of negative curvature "
      "({}, iteration {}); reduce the step size",
      method, iteration);
}

}  // namespace loomstone
