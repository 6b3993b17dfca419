// Residuals b - A x in double precision. Norms are sqrt(r . D^-1 r) on free rows, with D the
// diagonal blocks.
#pragma once

#include "core/linalg/pcg_memory.h"

namespace loomstone {

// Sets PcgMemory::residual to b - A x, with zeros on fixed rows. Returns its norm. Collective.
double true_residual(PcgSolve& solve, const Points& b, bool x_is_zero);

// As true_residual(), but computed from matrix_times_x. Requires that only b and the terms differ
// from the last solve. The result has single precision, like the iteration that left
// matrix_times_x. Collective.
double known_residual(PcgSolve& solve, const Points& b);

// Keeps the iteration of a solve that stopped early. Computes matrix_times_x from its
// single-precision residual. Collective.
void keep_iteration(PcgSolve& solve, const Points& b);

}  // namespace loomstone
