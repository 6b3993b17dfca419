// The linear system of an implicit step, common to all implicit integrators.
#pragma once

#include <memory>

#include "core/cloth/elasticity.h"
#include "core/integration/integrator.h"
#include "core/linalg/linear_solver.h"
#include "core/linalg/matrix_halo.h"

namespace loomstone {

// The system (A + c_k sum J^T H J + body masses) x = rhs. A is the matrix of `elasticity`. The sum
// is over the extra terms of `inputs`, with J and H as in core/linalg/extra_terms.h. Rows of
// prescribed motion keep their value of x.
struct StepSystem {
  const StepInputs& inputs;
  Elasticity& elasticity;
  double c_k;
  RowsIn rhs;
  double tolerance = 0.0;            // tolerance of the iterative solver [1]; 0: as in its options
  const Vector* masses = nullptr;    // see LinearSystem
  Vec3 least_change = Vec3::Zero();  // see LinearSystem
};

class StepSolve {
 public:
  explicit StepSolve(const LinearOptions& options) : solver_(make_linear_solver(options)) {}

  // Returns the halo of this rank for products with `matrix`. It is recomputed only if the number
  // of blocks changes.
  const Halo& halo(const BlockMatrix& matrix, const RowLayout& layout) {
    if (halo_blocks_ != matrix.n_blocks()) {  // the pattern depends only on the mesh
      halo_ = matrix_halo(matrix, layout);
      halo_blocks_ = matrix.n_blocks();
    }
    return halo_;
  }

  LinearReport solve(const Team& team, const RowLayout& layout, const StepSystem& step, Points& x,
                     SolveMemory& memory, Unchanged unchanged) {
    const BlockMatrix& matrix = step.elasticity.matrix();
    LinearSystem system;
    system.matrix = &matrix;
    system.body_blocks = step.inputs.body_mass;
    system.terms = step.inputs.terms;
    system.term_scale = step.c_k;
    system.fixed = step.inputs.fixed;
    system.layout = &layout;
    system.halo = &halo(matrix, layout);
    system.tolerance = step.tolerance;
    system.masses = step.masses;
    system.least_change = step.least_change;
    return solver_->solve(team, system, step.rhs, x, memory, unchanged);
  }

 private:
  std::unique_ptr<LinearSolver> solver_;
  Halo halo_;
  Index halo_blocks_ = -1;
};

}  // namespace loomstone
