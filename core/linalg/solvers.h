// Factory functions of the linear solvers.
#pragma once

#include "core/linalg/linear_solver.h"

namespace loomstone {

std::unique_ptr<LinearSolver> make_pcg(const LinearOptions& options);
std::unique_ptr<LinearSolver> make_block_jacobi(const LinearOptions& options);
std::unique_ptr<LinearSolver> make_gauss_seidel(const LinearOptions& options);
std::unique_ptr<LinearSolver> make_cholmod(const LinearOptions& options);

}  // namespace loomstone
