// Linear solvers for (A + term_scale sum_terms J^T H J + body blocks) x = b on free rows. A is the
// matrix of the cloth rows. J and H are the Jacobian and the Hessian of a term (extra_terms.h).
// Fixed rows keep their given value of x (exact constraints by filtering, [Baraff1998]).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/choice.h"
#include "core/base/own_rows.h"
#include "core/base/types.h"
#include "core/linalg/block_matrix.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

struct LinearSystem {
  // Matrix A of the cloth rows: mass plus multiples of stiffness and damping; null if there are no
  // cloth rows. Each rank needs only the rows that it owns. If the pattern changes between two
  // solves with the same SolveMemory, it must change on all ranks.
  const BlockMatrix* matrix = nullptr;
  // Diagonal blocks of the body rows, which follow the cloth rows (2 blocks per body); null if
  // there are no bodies.
  const std::vector<Mat3>* body_blocks = nullptr;
  const ExtraTerms* terms = nullptr;                 // may be null
  double term_scale = 0.0;                           // factor of every H (h^2 for backward Euler)
  const std::vector<std::uint8_t>* fixed = nullptr;  // (rows) 1: x is prescribed; may be null
  // Layout of all rows, bodies included. The solver computes the rows that this rank owns.
  const RowLayout* layout = nullptr;
  const Halo* halo = nullptr;  // halo of `matrix`, without rows of terms; null: it is computed
  double tolerance = 0.0;      // replaces the solver's tolerance [1]; 0: no replacement
  // Iterative solvers divide the norm of the residual by the larger of two norms: that of the
  // residual for x = 0 on free rows, and that of the momentum that `least_change` would give to the
  // masses of free cloth rows. With x in [m/s], masses are in [kg] and the change is in [m/s]. The
  // masses may be null; the second norm is then 0.
  const Vector* masses = nullptr;
  Vec3 least_change = Vec3::Zero();
};

struct LinearReport {
  int iterations = 0;
  // Iterative solvers: the norm sqrt(r . D^-1 r) divided by the larger of two norms, that of the
  // residual for x = 0 on free rows and that of the momentum of `least_change` [1]. r is the
  // residual on free rows, and D consists of the diagonal blocks of the system for which the
  // preconditioner was built. If a loose tolerance (LinearSystem::tolerance above that of the
  // solver) ended the solve early, r is the residual that the iteration updates, not b - A x.
  // Direct solvers: |r| divided by its value for x = 0 on free rows [1].
  double residual = 0.0;
  bool converged = true;
};

enum class LinearMethod { Pcg, BlockJacobi, GaussSeidel, Direct, Supernodal };
constexpr auto choices(LinearMethod) {
  using M = LinearMethod;
  return std::array{
      ChoiceName{M::Pcg, "pcg", "conjugate gradients with aggregation multigrid"},
      ChoiceName{M::BlockJacobi, "block-jacobi",
                 "conjugate gradients with a block-diagonal preconditioner"},
      ChoiceName{M::GaussSeidel, "gauss-seidel",
                 "conjugate gradients with a symmetric Gauss-Seidel preconditioner, one thread"},
      ChoiceName{M::Direct, "direct", "sparse Cholesky factorisation"},
      ChoiceName{M::Supernodal, "supernodal",
                 "sparse Cholesky factorisation by dense blocks; builds from sources only"}};
}

struct LinearOptions {
  LinearMethod method = LinearMethod::Pcg;
  double tolerance = 1e-4;  // tolerated LinearReport::residual of iterative solvers [1]
  int max_iterations = 2000;
};

struct PcgMemory;

// Data that a solve by conjugate gradients leaves for the next one: the matrix in single precision,
// the preconditioner and, if a loose tolerance ended the iteration early in single precision, the
// state of the iteration. The memory belongs to the caller. It is empty at first and after a solve
// that threw SolverFailure. Its storage is reused, which does not change results.
class SolveMemory {
 public:
  SolveMemory();
  ~SolveMemory();
  SolveMemory(SolveMemory&&) noexcept;
  SolveMemory& operator=(SolveMemory&&) noexcept;

  PcgMemory& pcg() { return *pcg_; }
  // solver_bytes() returns the memory of matrix copies, their layout, terms, lists of blocks and
  // vectors, and preconditioner_bytes() that of the preconditioner [bytes].
  std::size_t solver_bytes() const;
  std::size_t preconditioner_bytes() const;

 private:
  std::unique_ptr<PcgMemory> pcg_;
};

// Part of the system that is unchanged since the solve that filled the memory.
// Nothing: everything may have changed.
// Matrix: only terms, right-hand side, guess and tolerance may have changed. The preconditioner is
//   reused unless it is Gauss-Seidel. If a loose tolerance ended that solve early in single
//   precision and the guess x is its solution, the product A x is reused too.
// System: only the tolerance may have changed. If a loose tolerance ended that solve early in
//   single precision, its iteration resumes.
enum class Unchanged { Nothing, Matrix, System };

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  // Solves for x (rows x 3) with the right-hand side b (rows x 3). Only the rows of this rank are
  // needed in b. On entry, x is the initial guess on free rows and the prescribed value on fixed
  // rows. On return, x is the solution on the rows of all ranks. Throws InvalidInput if the sizes
  // of system, b and x disagree, Unsupported on several ranks if the method runs only on one,
  // StepFailure if the solver finds that the matrix is not finite or not positive definite, and a
  // SolverFailure that is no StepFailure if b or a prescribed value is not finite or memory runs
  // out. Iterative solvers replace an initial guess that is not finite by zero.
  virtual LinearReport solve(const Team& team, const LinearSystem& system, const RowsIn& b,
                             Points& x, SolveMemory& memory, Unchanged unchanged) = 0;
  // Solves without memory of earlier solves.
  LinearReport solve(const Team& team, const LinearSystem& system, const RowsIn& b, Points& x) {
    SolveMemory memory;
    return solve(team, system, b, x, memory, Unchanged::Nothing);
  }
};

// Throws InvalidInput if tolerance or max_iterations is out of range, and Unsupported if the method
// is Supernodal and the CHOLMOD library has no supernodal module.
std::unique_ptr<LinearSolver> make_linear_solver(const LinearOptions& options);

}  // namespace loomstone
