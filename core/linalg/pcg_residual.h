// Residuals b - A x in double precision. Norms are sqrt(r . D^-1 r) with D the diagonal blocks, on
// free rows.
#pragma once

#include "core/linalg/pcg_memory.h"

namespace loomstone {

// Sets PcgMemory::residual to b - A x, zero on fixed rows; returns its norm. Collective.
double true_residual(PcgSolve& solve, const Points& b, bool x_is_zero);

// The same where matrix_times_x is known and only b and the terms differ from the last solve; to
// single precision, as the iteration that left it. Collective.
double known_residual(PcgSolve& solve, const Points& b);

// Keeps the iteration of a solve that stopped early, with the matrix times x, from its residual in
// single precision. Collective.
void keep_iteration(PcgSolve& solve, const Points& b);

}  // namespace loomstone
