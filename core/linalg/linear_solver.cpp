#include "core/linalg/linear_solver.h"

#include <cmath>

#include "core/base/error.h"
#include "core/linalg/pcg_memory.h"
#include "core/linalg/solvers.h"

namespace loomstone {

SolveMemory::SolveMemory() : pcg_(std::make_unique<PcgMemory>()) {}
SolveMemory::~SolveMemory() = default;
SolveMemory::SolveMemory(SolveMemory&&) noexcept = default;
SolveMemory& SolveMemory::operator=(SolveMemory&&) noexcept = default;

std::unique_ptr<LinearSolver> make_linear_solver(const LinearOptions& options) {
  if (!(options.tolerance > 0.0) || !std::isfinite(options.tolerance))
    throw InvalidInput("the linear solver's tolerance must be > 0 [1], got " +
                       std::to_string(options.tolerance) + "; 1e-4 suits a step of 1 ms");
  if (options.max_iterations < 1)
    throw InvalidInput("the linear solver's max_iterations must be >= 1, got " +
                       std::to_string(options.max_iterations) + "; 2000 is the default");
  if (options.method == "pcg") return make_pcg(options);
  if (options.method == "block-jacobi") return make_block_jacobi(options);
  if (options.method == "gauss-seidel") return make_gauss_seidel(options);
  if (options.method == "direct") return make_cholmod(options);
  throw InvalidInput(
      "the linear solver's method must be \"pcg\", \"block-jacobi\", \"gauss-seidel\" or "
      "\"direct\", got \"" +
      options.method + "\"; choose one of them");
}

}  // namespace loomstone
