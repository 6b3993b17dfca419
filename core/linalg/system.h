// Operations on a LinearSystem for its solvers: checks, diagonal blocks, products and errors.
#pragma once

#include <vector>

#include "core/linalg/linear_solver.h"
#include "core/linalg/term_rows.h"

namespace loomstone {

// Range [first, last) of this rank's blocks of rows_per_block rows.
struct OwnedBlocks {
  Index first = 0, last = 0;
};
OwnedBlocks owned_blocks(const RowLayout& layout);

// Returns the number of cloth rows, which are the rows of the matrix. Body rows follow.
inline Index n_cloth_rows(const LinearSystem& system) {
  return system.matrix ? system.matrix->n_rows() : 0;
}
inline bool is_fixed(const LinearSystem& system, Index row) {
  return system.fixed != nullptr && (*system.fixed)[row] != 0;
}

// Throws InvalidInput if the sizes of system, b and x disagree.
void check_system(const LinearSystem& system, const RowsIn& b, const Points& x);

// Returns the diagonal block of a cloth row or body row, including terms.
Mat3 diagonal_block(const LinearSystem& system, const TermRows& terms, Index row);

// Computes y = A x on rows [begin, end), where A includes body blocks and terms. x and y have 4
// doubles per row. x has all rows, and y only the rows [begin, end). terms.evaluate(x) must have
// been called before.
void multiply_system(const LinearSystem& system, const TermRows& terms, Index begin, Index end,
                     const double* x, double* y);

// To be called on all ranks if a product or norm is not finite. Throws SolverFailure, whose message
// names the first row of b or x that is not finite, or StepFailure if all rows of b and x are
// finite. Collective.
[[noreturn]] void throw_not_finite(const LinearSystem& system, const RowsIn& b, const Points& x);

// Throws StepFailure on all ranks if a rank has found a row whose diagonal block is not positive
// definite. `bad_row` is -1 on ranks that have found none. Collective.
void refuse_indefinite_row(const LinearSystem& system, Index bad_row);
[[noreturn]] void throw_indefinite(const char* method, int iteration);

}  // namespace loomstone
