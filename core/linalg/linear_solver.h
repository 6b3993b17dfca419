// Solves (A + scale sum_terms J^T H J + body blocks) x = b on rows that are free; fixed rows keep
// the value of x that they are given (exact constraints by filtering, [Baraff1998]).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/choice.h"
#include "core/base/types.h"
#include "core/linalg/block_matrix.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

struct LinearSystem {
  const BlockMatrix* matrix = nullptr;  // cloth rows 0 .. n-1, mass and stiffness together
  // Diagonal blocks of the rows that follow (2 a body); may be null.
  const std::vector<Mat3>* body_blocks = nullptr;
  const ExtraTerms* terms = nullptr;                 // may be null
  double term_scale = 0.0;                           // factor of every H (h^2 for backward Euler)
  const std::vector<std::uint8_t>* fixed = nullptr;  // (rows) 1: the row's x is prescribed
  // Over all rows, bodies included; the solver computes owned rows.
  const RowLayout* layout = nullptr;
  const Halo* halo = nullptr;  // of `matrix`; rows the terms need are added by the solver
  double tolerance = 0.0;      // of iterations, in place of the solver's; 0: the solver's
};

struct LinearReport {
  int iterations = 0;
  // sqrt(r . D^-1 r) relative to its value for x = 0 on free rows, D the diagonal blocks (direct:
  // |r| / |b|)
  double residual = 0.0;
  bool converged = true;
};

enum class LinearMethod { Pcg, BlockJacobi, GaussSeidel, Direct };
constexpr auto choices(LinearMethod) {
  using M = LinearMethod;
  return std::array{
      ChoiceName{M::Pcg, "pcg", "conjugate gradients with aggregation multigrid"},
      ChoiceName{M::BlockJacobi, "block-jacobi", "with the diagonal blocks"},
      ChoiceName{M::GaussSeidel, "gauss-seidel", "with symmetric Gauss-Seidel, one thread"},
      ChoiceName{M::Direct, "direct", "sparse Cholesky factorisation"}};
}

struct LinearOptions {
  LinearMethod method = LinearMethod::Pcg;
  double tolerance = 1e-4;  // on the preconditioned norm [1]
  int max_iterations = 2000;
};

struct PcgMemory;

// The memory that a solve leaves to the next one: its preconditioner, and its iteration where a
// loose tolerance ended it early. A value that belongs to the caller; empty at first, and after a
// solve that threw. Storage is used again, which changes no result.
class SolveMemory {
 public:
  SolveMemory();
  ~SolveMemory();
  SolveMemory(SolveMemory&&) noexcept;
  SolveMemory& operator=(SolveMemory&&) noexcept;

  PcgMemory& pcg() { return *pcg_; }

 private:
  std::unique_ptr<PcgMemory> pcg_;
};

// The part of a system that equals the one whose solve filled the memory: nothing; all but terms,
// right side and tolerance (the preconditioner is used again, and the iteration where x is the
// solution it left); all but the tolerance (the iteration goes on).
enum class Unchanged { Nothing, Matrix, System };

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  // b (rows x 3); x (rows x 3): initial guess in, solution out; owned rows are written, then all
  // rows are refreshed. Throws SolverFailure.
  virtual LinearReport solve(const Team& team, const LinearSystem& system, const Points& b,
                             Points& x, SolveMemory& memory, Unchanged unchanged) = 0;
  // A solve on its own.
  LinearReport solve(const Team& team, const LinearSystem& system, const Points& b, Points& x) {
    SolveMemory memory;
    return solve(team, system, b, x, memory, Unchanged::Nothing);
  }
};

// Throws InvalidInput where tolerance or max_iterations cannot be met.
std::unique_ptr<LinearSolver> make_linear_solver(const LinearOptions& options);

}  // namespace loomstone
