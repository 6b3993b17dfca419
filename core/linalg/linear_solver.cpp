#include "core/linalg/linear_solver.h"

#include <cmath>

#include "core/base/message.h"
#include "core/linalg/pcg_memory.h"
#include "core/linalg/solvers.h"

namespace loomstone {

SolveMemory::SolveMemory() : pcg_(std::make_unique<PcgMemory>()) {}
SolveMemory::~SolveMemory() = default;
SolveMemory::SolveMemory(SolveMemory&&) noexcept = default;
SolveMemory& SolveMemory::operator=(SolveMemory&&) noexcept = default;

std::size_t SolveMemory::solver_bytes() const {
  const PcgMemory& m = *pcg_;
  return bytes_of(m.slices, m.terms, m.inner_blocks, m.outer_blocks, m.single, m.wide, m.x,
                  m.residual, m.matrix_times_x);
}
std::size_t SolveMemory::preconditioner_bytes() const { return pcg_->preconditioner.bytes(); }

std::unique_ptr<LinearSolver> make_linear_solver(const LinearOptions& options) {
  if (!(options.tolerance > 0.0) || !std::isfinite(options.tolerance))
    fail<InvalidInput>(
        "the linear solver's tolerance must be > 0 [1], got {}; 1e-4 suits a step of 1 ms",
        options.tolerance);
  if (options.max_iterations < 1)
    fail<InvalidInput>(
        "the linear solver's max_iterations must be >= 1, got {}; 2000 is the default",
        options.max_iterations);
  switch (options.method) {
    case LinearMethod::Pcg:
      return make_pcg(options);
    case LinearMethod::BlockJacobi:
      return make_block_jacobi(options);
    case LinearMethod::GaussSeidel:
      return make_gauss_seidel(options);
    case LinearMethod::Direct:
    case LinearMethod::Supernodal:
      break;
  }
  return make_cholmod(options);
}

}  // namespace loomstone
