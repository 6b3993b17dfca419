// The iteration of preconditioned conjugate gradients, in single or double precision. Three
// parallel regions an iteration, one more with extra terms.
#pragma once

#include "core/linalg/pcg_memory.h"

namespace loomstone {

// How a run of iterations begins: from the residual in PcgMemory::residual, along the
// preconditioned residual (Restart) or conjugate to the last direction (Conjugate); or where the
// last run of the same system ended (Resume).
enum class Start { Restart, Conjugate, Resume };

struct StoppingRule {
  double norm;         // of the iterated residual
  int max_iterations;  // of the whole solve
};

// Iterates with r and p scaled by 1 / b_norm, so that single precision can neither under- nor
// overflow; adds to x and `iterations`; returns the norm of the iterated residual. Stops early in
// single precision where the matrix looks indefinite to it; in double precision throws
// SolverFailure there. Collective.
template <class Scalar>
double iterate(PcgSolve& solve, Krylov<Scalar>& k, Start start, const StoppingRule& stop,
               int& iterations);

}  // namespace loomstone
