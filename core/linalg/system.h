// Operations on a LinearSystem that all solvers share: checks, diagonal blocks, product, errors.
#pragma once

#include <vector>

#include "core/linalg/linear_solver.h"
#include "core/linalg/term_rows.h"

namespace loomstone {

// Blocks of rows_per_block rows that this rank owns: [first, last).
struct OwnedBlocks {
  Index first = 0, last = 0;
};
OwnedBlocks owned_blocks(const RowLayout& layout);

// Number of cloth rows (those of the matrix); bodies follow.
inline Index n_cloth_rows(const LinearSystem& system) {
  return system.matrix ? system.matrix->n_rows() : 0;
}
inline bool is_fixed(const LinearSystem& system, Index row) {
  return system.fixed != nullptr && (*system.fixed)[row] != 0;
}

// Throws InvalidInput where sizes disagree.
void check_system(const LinearSystem& system, const Points& b, const Points& x);

// Diagonal block of a row, body blocks and terms included.
Mat3 diagonal_block(const LinearSystem& system, const TermRows& terms, Index row);

// y = A x on rows [begin, end), 4 doubles a row; terms.evaluate(x) must have run.
void multiply_system(const LinearSystem& system, const TermRows& terms, Index begin, Index end,
                     const double* x, double* y);

// Throws SolverFailure on all ranks, naming the first row of b (or x) that is not finite.
// Collective.
[[noreturn]] void throw_not_finite(const LinearSystem& system, const Points& b, const Points& x);

// Throws SolverFailure on all ranks where one of them met a row whose diagonal block is not
// positive definite (`bad_row` is -1 where a rank met none). Collective.
void refuse_indefinite_row(const LinearSystem& system, Index bad_row);
[[noreturn]] void throw_indefinite(const char* method, int iteration);

}  // namespace loomstone
