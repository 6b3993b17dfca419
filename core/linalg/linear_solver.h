// Solves (A + scale sum_terms J^T H J + body blocks) x = b on rows that are free; fixed rows keep
// the value of x they come with (exact constraints by filtering).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/linalg/block_matrix.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

struct LinearSystem {
  const BlockMatrix* matrix = nullptr;  // cloth rows 0 .. n-1, mass and stiffness together
  const std::vector<Mat3>* body_blocks =
      nullptr;  // diagonal blocks of the rows that follow (2 a body); may be null
  const ExtraTerms* terms = nullptr;                 // may be null
  double term_scale = 0.0;                           // factor of every H (h^2 for backward Euler)
  const std::vector<std::uint8_t>* fixed = nullptr;  // (rows) 1: the row's x is prescribed
  const RowLayout* layout =
      nullptr;                 // over all rows, bodies included; the solver computes owned rows
  const Halo* halo = nullptr;  // of `matrix`; rows the terms need are added by the solver
  bool same_matrix = false;    // all but terms and tolerance is what the last solve was given; its
                               // preconditioner may serve
  // The last solve was given all of this but for the tolerance, and left x: its iteration may go
  // on. With same_matrix alone.
  bool same_system = false;
  double tolerance = 0.0;  // of iterations, in place of the solver's; 0: the solver's
};

struct LinearReport {
  int iterations = 0;
  double residual =
      0.0;  // sqrt(r . P^-1 r) relative to its value for x = 0 on free rows (direct: |r|/|b|)
  bool converged = true;
};

struct LinearOptions {
  // "pcg" (conjugate gradients, diagonal blocks and coarse levels) | "block-jacobi" (diagonal
  // blocks alone) | "gauss-seidel" (preconditioned by symmetric Gauss-Seidel) | "direct" (CHOLMOD)
  std::string method = "pcg";
  double tolerance = 1e-4;  // on the preconditioned norm [1]
  int max_iterations = 2000;
};

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  // b (rows x 3); x (rows x 3): initial guess in, solution out; owned rows are written, then all
  // rows are refreshed.
  virtual LinearReport solve(const Team& team, const LinearSystem& system, const Points& b,
                             Points& x) = 0;
};

// Throws InvalidInput for an unknown method.
std::unique_ptr<LinearSolver> make_linear_solver(const LinearOptions& options);

}  // namespace loomstone
