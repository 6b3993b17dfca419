// Residuals b - A x, stored in double precision. Norms are sqrt(r . D^-1 r) over the free rows,
// where D consists of the diagonal blocks for which the preconditioner was built.
#pragma once

#include "core/linalg/pcg_memory.h"

namespace loomstone {

// Sets PcgMemory::residual to b - A x, or to b if `x_is_zero`, with zeros on fixed rows. Returns
// its norm. Collective.
double true_residual(PcgSolve& solve, const RowsIn& b, bool x_is_zero);

// Returns the norm of the momentum that LinearSystem::least_change gives to the masses of free
// cloth rows, or 0 without masses. May overwrite PcgMemory::residual. Collective.
double least_norm(PcgSolve& solve);

// Like true_residual(), but uses PcgMemory::matrix_times_x of the last solve instead of a matrix
// product. Since that solve, only b and the extra terms may have changed. The result is accurate to
// single precision, like the residuals of that solve. Collective.
double known_residual(PcgSolve& solve, const RowsIn& b);

// Prepares the memory of a solve that stopped early, so that the next solve can continue from its
// last iteration. Computes matrix_times_x from the single-precision residual of this iteration.
// Collective.
void keep_iteration(PcgSolve& solve, const RowsIn& b);

}  // namespace loomstone
