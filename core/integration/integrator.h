// Advances all cloth by one step. One virtual call a step; the options choose the scheme.
// docs/method.md, "Integrators"; thesis (2.51)-(2.55).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/types.h"
#include "core/cloth/cloth_model.h"
#include "core/cloth/cloth_state.h"
#include "core/cloth/elasticity.h"
#include "core/integration/options.h"
#include "core/linalg/extra_terms.h"
#include "core/linalg/linear_solver.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

// Evaluates the terms of a step where the rows have moved by `displacement` (rows x 3) [m] in
// `time` [s]: `terms` are given as those of the start; sets their gradient and hessian and returns
// their energy [J].
using TermsAt = std::function<double(const Points& displacement, double time, TermRequest request,
                                     ExtraTerms& terms)>;

// Sets the friction of `terms`, linear about the start, to that for where the rows have moved in
// `time` [s]. Returns the share of friction that the terms had wrong [1].
using FrictionAt =
    std::function<double(const Points& displacement, double time, ExtraTerms& terms)>;

// Input of a step. Rows: cloth vertices, then two rows a rigid body (translation, rotation) where
// bodies take part.
struct StepInputs {
  double step = 0.0;              // h [s]
  double time = 0.0;              // at the start [s]
  const Points* force = nullptr;  // (n x 3) loads at the start [N]: gravity, drag, user
  const ExtraTerms* terms =
      nullptr;  // contacts, friction, attachments at the start; implicit schemes only
  const TermsAt* terms_at =
      nullptr;  // called once an iterate by Newton loops; null: the terms are linear
  const FrictionAt* friction_at =
      nullptr;  // called after a linear solve, which is repeated where it was wrong; may be null
  const std::vector<std::uint8_t>* fixed = nullptr;  // (rows) 1: motion is prescribed
  const Points* target = nullptr;                // (n x 3) positions of fixed rows at the end [m]
  const std::vector<Mat3>* body_mass = nullptr;  // (2 b) mass times identity, world inertia
};

struct IntegrationReport {
  int newton_iterations = 1;
  int linear_iterations = 0;
  double residual = 0.0;
  std::vector<double>
      newton_residuals;  // relative: first guess, then after each iteration; Newton loops only
};

// No solution was found, and a shorter step may have one.
class StepFailure : public SolverFailure {
 public:
  using SolverFailure::SolverFailure;
};

// A Newton loop that ends without a solution; `row` is where the residual is largest.
class NewtonFailure : public StepFailure {
 public:
  NewtonFailure(const std::string& what, Index row) : StepFailure(what), row(row) {}
  Index row;
};

// Stage.
class Integrator {
 public:
  virtual ~Integrator() = default;
  // state.x, state.v: start in, end out on all rows of all ranks. body_velocity (2 b x 3):
  // predicted velocities in (loads on the bodies included), velocities after contacts out. Throws
  // SolverFailure.
  virtual IntegrationReport advance(const Team& team, const RowLayout& layout,
                                    const StepInputs& inputs, ClothState& state,
                                    Points& body_velocity) = 0;
  virtual bool implicit() const = 0;                  // takes extra terms
  virtual bool asks_energy() const { return false; }  // evaluates the whole cloth on every rank
};

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options,
                                            const ClothModel& model, Elasticity& elasticity);

// How bending enters: BendingInStep::Auto puts it into the solve when h (h + 2 beta) lambda > (0.8
// * 2)^2, beta its damping [s] and lambda the largest eigenvalue of M^-1 K. Semi-implicit Euler
// without bending damping takes the sparse bound of the stiffness unless the Jacobian is exact.
BendingTreatment bending_treatment(const IntegratorOptions& options, const ClothModel& model);

}  // namespace loomstone
