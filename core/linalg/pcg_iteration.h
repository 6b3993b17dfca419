// Iteration of preconditioned conjugate gradients, in single or double precision. On one rank, a
// step has three parallel regions, one more with extra terms, one more in every 16th step, and the
// regions of the multigrid levels.
#pragma once

#include "core/linalg/pcg_memory.h"

namespace loomstone {

// Ways to begin a run of iterations. Restart and Conjugate use the residual in PcgMemory::residual.
// With Restart, the first direction is the preconditioned residual. With Conjugate, it is conjugate
// to the last direction. Resume continues where the last run for the same system ended.
enum class Start { Restart, Conjugate, Resume };

struct StoppingRule {
  double norm;         // norm of the iterated residual (see pcg.cpp) at which to stop
  int max_iterations;  // limit for the whole solve
};

// Iterates with r and p scaled by 1 / b_norm, so that the magnitude of b causes neither underflow
// nor overflow in single precision. Adds the steps to x and their number to `iterations`. Returns
// the norm of the iterated residual (see StoppingRule). If p . A p is not finite or not positive,
// stops early in single precision and throws StepFailure in double precision. Collective.
template <class Scalar>
double iterate(PcgSolve& solve, Krylov<Scalar>& k, Start start, const StoppingRule& stop,
               int& iterations);

}  // namespace loomstone
