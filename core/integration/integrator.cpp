#include "core/integration/integrator.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/integration/schemes.h"

namespace loomstone {

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options,
                                            const ClothModel& model, Elasticity& elasticity) {
  const std::string& m = options.method;
  if (options.is_explicit()) return make_explicit(options, model, elasticity);
  if (m == "semi-implicit-euler" || m == "implicit-midpoint" || m == "bdf2")
    return make_linearised(options, model, elasticity);
  if (m == "backward-euler" || m == "nonlinear-midpoint")
    return make_newton(options, model, elasticity);
  throw InvalidInput(
      "integrator.method must be one of explicit-euler, symplectic-euler, semi-implicit-euler, "
      "backward-euler, implicit-midpoint, nonlinear-midpoint, bdf2, got \"" +
      m + "\"");
}

namespace {
// Largest beta of bending damping proportional to stiffness [s].
double largest_bending_damping(const ClothModel& model) {
  double largest = 0.0;
  for (const auto& part : model.bending)
    for (const double damping : part.setup.damping) largest = std::max(largest, damping);
  return largest;
}

bool bending_is_implicit(const IntegratorOptions& options, const ClothModel& model) {
  if (options.bending == "implicit") {
    if (options.is_explicit())
      throw InvalidInput("integrator.bending must be explicit or auto for " + options.method +
                         ", got implicit; choose an implicit integrator");
    return true;
  }
  if (options.bending == "explicit" || (options.bending == "auto" && options.is_explicit()))
    return false;
  if (options.bending != "auto")
    throw InvalidInput("integrator.bending must be auto, explicit or implicit, got \"" +
                       options.bending + "\"");
  // Explicit in an implicit step, with damping beta K v of its start, it is stable while h (h + 2
  // beta) lambda < 4.
  const double limit = 0.8 * 2.0;
  return options.step * (options.step + 2.0 * largest_bending_damping(model)) *
             Elasticity::bending_eigenvalue(model) >
         limit * limit;
}
}  // namespace

BendingTreatment bending_treatment(const IntegratorOptions& options, const ClothModel& model) {
  if (!bending_is_implicit(options, model)) return BendingTreatment::Explicit;
  if (options.method != "semi-implicit-euler" || options.jacobian == "exact")
    return BendingTreatment::Full;
  return largest_bending_damping(model) > 0.0 ? BendingTreatment::Full : BendingTreatment::Lumped;
}

void prescribe_velocities(const StepInputs& inputs, const Points& x, Points& v) {
  for (Index i = 0; i < x.rows(); ++i)
    if ((*inputs.fixed)[i]) v.row(i) = (inputs.target->row(i) - x.row(i)) / inputs.step;
}

void place_fixed(const StepInputs& inputs, Points& x) {
  for (Index i = 0; i < x.rows(); ++i)
    if ((*inputs.fixed)[i]) x.row(i) = inputs.target->row(i);
}

namespace {
void add_force(const ExtraTerm& term, const Vec3& force, const RowLayout& layout, Points& rhs) {
  for (int e = 0; e < term.n_entries; ++e) {
    const TermEntry& entry = term.entries[e];
    if (layout.owns(entry.row)) rhs.row(entry.row) += entry.apply_transposed(force).transpose();
  }
}
}  // namespace

void add_term_forces(const ExtraTerms& terms, const RowLayout& layout, double sigma, double time,
                     const Points& displacement, Points& rhs) {
  for (const ExtraTerm& term : terms)
    add_force(
        term,
        -sigma * (term.gradient + term.hessian * term.relative_displacement(displacement, time)),
        layout, rhs);
}

void add_term_gradients(const ExtraTerms& terms, const RowLayout& layout, double sigma,
                        Points& rhs) {
  for (const ExtraTerm& term : terms) add_force(term, -sigma * term.gradient, layout, rhs);
}

}  // namespace loomstone
