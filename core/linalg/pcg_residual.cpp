#include "core/linalg/pcg_residual.h"

#include <cmath>

#include "core/linalg/pcg_kernels.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

double square_of_residual(const PcgMemory& m, Index begin, Index end) {
  return pcg::preconditioned_square(m.slices.first_slice(begin), m.slices.last_slice(end),
                                    m.preconditioner.inverse<float>(), m.residual.data());
}

}  // namespace

double true_residual(PcgSolve& solve, const RowsIn& b, bool x_is_zero) {
  PcgMemory& m = solve.memory;
  const PcgSolve::WholeVector x = x_is_zero ? PcgSolve::WholeVector{} : solve.whole_x();
  return std::sqrt(solve.loops.sum_over_blocks([&](Index begin, Index end) {
    alignas(64) double product[4 * rows_per_block];
    if (!x_is_zero) multiply_system(solve.system, m.terms, begin, end, x.data, product);
    for (Index row = begin; row < end; ++row) {
      const bool fixed = is_fixed(solve.system, row);
      solve.set_row(row, m.residual, [&](std::size_t, int d) {
        return fixed ? 0.0 : x_is_zero ? b(row, d) : b(row, d) - product[row_at(row - begin) + d];
      });
    }
    return square_of_residual(m, begin, end);
  }));
}

double least_norm(PcgSolve& solve) {
  const LinearSystem& system = solve.system;
  if (!system.masses || system.least_change.isZero(0.0)) return 0.0;
  PcgMemory& m = solve.memory;
  return std::sqrt(solve.loops.sum_over_blocks([&](Index begin, Index end) {
    for (Index row = begin; row < end; ++row) {
      const bool cloth = row < system.masses->size() && !is_fixed(system, row);
      const double mass = cloth ? (*system.masses)[row] : 0.0;
      solve.set_row(row, m.residual,
                    [&](std::size_t, int d) { return mass * system.least_change[d]; });
    }
    return square_of_residual(m, begin, end);
  }));
}

double known_residual(PcgSolve& solve, const RowsIn& b) {
  PcgMemory& m = solve.memory;
  solve.whole_x();  // evaluates the terms
  return std::sqrt(solve.loops.sum_over_blocks([&](Index begin, Index end) {
    for (Index row = begin; row < end; ++row) {
      const bool fixed = is_fixed(solve.system, row);
      solve.set_row(row, m.residual, [&](std::size_t i, int d) {
        return fixed ? 0.0 : b(row, d) - m.matrix_times_x[i];
      });
    }
    m.terms.for_touched(begin, end, [&](Index row) {
      if (is_fixed(solve.system, row)) return;
      const Vec3 force = m.terms.force(row);
      solve.set_row(row, m.residual,
                    [&](std::size_t i, int d) { return m.residual[i] - force[d]; });
    });
    return square_of_residual(m, begin, end);
  }));
}

void keep_iteration(PcgSolve& solve, const RowsIn& b) {
  PcgMemory& m = solve.memory;
  solve.whole_x();  // evaluates the terms
  m.matrix_times_x.resize(m.residual.size());
  solve.loops.over_blocks([&](Index, Index begin, Index end) {
    for (Index row = begin; row < end; ++row)
      solve.set_row(row, m.matrix_times_x, [&](std::size_t i, int d) {
        return b(row, d) - m.b_norm * static_cast<double>(m.single.r[i]);
      });
    m.terms.for_touched(begin, end, [&](Index row) {
      const Vec3 force = m.terms.force(row);
      solve.set_row(row, m.matrix_times_x,
                    [&](std::size_t i, int d) { return m.matrix_times_x[i] - force[d]; });
    });
  });
  m.has_iteration = true;
}

}  // namespace loomstone
