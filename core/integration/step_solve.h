// The linear system of an implicit step, as all implicit integrators pose it.
#pragma once

#include <memory>

#include "core/cloth/elasticity.h"
#include "core/integration/integrator.h"
#include "core/linalg/linear_solver.h"
#include "core/linalg/matrix_halo.h"

namespace loomstone {

// Free bodies move by h v+ whatever the cloth's scheme, their stage being symplectic Euler, and
// feel the impulse h f. Where forces act at displacements of d v+ of bodies, and of (c_k / sigma) y
// of any row with y its unknown, a body's unknown is thus y = sigma d / c_k dv, and the system
// stays symmetric with c_k / (h d) of its mass.
struct BodyRows {
  double mass_share, velocity_share;  // of the masses in the system; dv = velocity_share * y

  BodyRows(double h, double sigma, double c_k, double d)
      : mass_share(c_k / (h * d)), velocity_share(c_k / (sigma * d)) {}

  // Masses for the system.
  std::vector<Mat3> masses(const std::vector<Mat3>* given) const {
    std::vector<Mat3> scaled = given ? *given : std::vector<Mat3>();
    for (Mat3& mass : scaled) mass *= mass_share;
    return scaled;
  }
};

class StepSolve {
 public:
  explicit StepSolve(const LinearOptions& options) : solver_(make_linear_solver(options)) {}

  // Rows of others that this rank's rows of `matrix` are coupled to.
  const Halo& halo(const BlockMatrix& matrix, const RowLayout& layout) {
    if (halo_blocks_ != matrix.n_blocks()) {  // the pattern is that of the mesh and stays
      halo_ = matrix_halo(matrix, layout);
      halo_blocks_ = matrix.n_blocks();
    }
    return halo_;
  }

  // (matrix of `elasticity` + c_k sum J^T H J + body masses) x = rhs; fixed rows keep the x they
  // come with. tolerance: of iterations, 0 for that of the options. unchanged: since the last solve
  // of this step.
  LinearReport solve(const Team& team, const RowLayout& layout, const StepInputs& inputs,
                     Elasticity& elasticity, double c_k, const Points& rhs, Points& x,
                     double tolerance = 0.0, Unchanged unchanged = Unchanged::Nothing) {
    const BlockMatrix& matrix = elasticity.matrix();
    LinearSystem system;
    system.matrix = &matrix;
    system.body_blocks = inputs.body_mass;
    system.terms = inputs.terms;
    system.term_scale = c_k;
    system.fixed = inputs.fixed;
    system.layout = &layout;
    system.halo = &halo(matrix, layout);
    system.tolerance = tolerance;
    return solver_->solve(team, system, rhs, x, memory_, unchanged);
  }

 private:
  std::unique_ptr<LinearSolver> solver_;
  SolveMemory memory_;
  Halo halo_;
  Index halo_blocks_ = -1;
};

}  // namespace loomstone
