#include "core/integration/integrator.h"

#include <algorithm>

#include "core/integration/integrator_factories.h"

namespace loomstone {

namespace {

// Makes the integrator of a scheme, with one overload per scheme.
struct Make {
  const ClothModel& model;
  Elasticity& elasticity;
  using Made = std::unique_ptr<Integrator>;

  Made operator()(const ExplicitEuler&) const { return make_explicit(false, model, elasticity); }
  Made operator()(const SymplecticEuler&) const { return make_explicit(true, model, elasticity); }
  Made operator()(const Asynchronous& options) const {
    return make_asynchronous(options, model, elasticity);
  }
  Made operator()(const SemiImplicitEuler& options) const {
    return make_linearised(Scheme::BackwardEuler, options, model, elasticity);
  }
  Made operator()(const ImplicitMidpoint& options) const {
    return make_linearised(Scheme::Midpoint, options, model, elasticity);
  }
  Made operator()(const Bdf2& options) const {
    return make_linearised(Scheme::Bdf2, options, model, elasticity);
  }
  Made operator()(const BackwardEuler& options) const {
    return make_newton(Scheme::BackwardEuler, options.name, options, model, elasticity);
  }
  Made operator()(const NonlinearMidpoint& options) const {
    return make_newton(Scheme::Midpoint, options.name, options, model, elasticity);
  }
};

}  // namespace

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options,
                                            const ClothModel& model, Elasticity& elasticity) {
  return options.visit(Make{model, elasticity});
}

namespace {
// Largest coefficient beta of stiffness-proportional bending damping [s].
double largest_bending_damping(const ClothModel& model) {
  double largest = 0.0;
  for (const auto& part : model.bending) largest = std::max(largest, part.damping);
  return largest;
}

// Growth rate of oscillations of explicit bending above which BendingInStep::Auto makes bending
// implicit in the midpoint rules and BDF-2 [1/s].
constexpr double tolerated_growth = 0.01;

// Returns whether bending is implicit. BendingInStep::Auto makes it implicit if explicit bending
// would be unstable or nearly so, or would amplify oscillations faster than tolerated_growth. In
// this function, h is the step, lambda the largest eigenvalue of M^-1 K for bending, beta the
// largest bending damping, and s = h (h + 2 beta) lambda.
bool bending_is_implicit(const IntegratorOptions& options, const ClothModel& model) {
  const ImplicitOptions& implicit = *options.implicit();
  if (implicit.bending != BendingInStep::Auto) return implicit.bending == BendingInStep::Implicit;
  const double h = implicit.step.given.value();
  const double s =
      h * (h + 2.0 * largest_bending_damping(model)) * Elasticity::bending_eigenvalue(model);
  // Midpoint and BDF-2 extrapolate the force and amplify every oscillation. In a step, amplitudes
  // grow by a fraction of about s^2 / 8 (midpoint) or s^2 / 4 (BDF-2).
  if (options.is<ImplicitMidpoint>() || options.is<NonlinearMidpoint>())
    return s * s / 8.0 > h * tolerated_growth;
  if (options.is<Bdf2>()) return s * s / 4.0 > h * tolerated_growth;
  // If the bending force, with its damping part beta K v, is evaluated at the start of the step,
  // the Euler schemes integrate bending by symplectic Euler, which is stable for sqrt(s) < 2. The
  // factor 0.8 is a safety margin.
  const double limit = 0.8 * 2.0;
  return s > limit * limit;
}
}  // namespace

BendingTreatment bending_treatment(const IntegratorOptions& options, const ClothModel& model) {
  const ImplicitOptions* implicit = options.implicit();
  if (implicit == nullptr || !bending_is_implicit(options, model))
    return BendingTreatment::Explicit;
  if (!options.is<SemiImplicitEuler>() || implicit->jacobian == JacobianKind::Exact)
    return BendingTreatment::Full;
  return largest_bending_damping(model) > 0.0 ? BendingTreatment::Full : BendingTreatment::Lumped;
}

void gather_cloth_rows(const RowLayout& layout, Points& table, Points& wide) {
  if (layout.single()) return;
  const Index n = static_cast<Index>(table.rows());
  wide.resize(layout.n_rows(), 3);
  wide.topRows(n) = table;
  layout.gather(wide.data(), 3);
  table = wide.topRows(n);
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
void add_force(const ExtraTerm& term, const Vec3& force, const RowLayout& layout, RowsOut rhs) {
  for (int e = 0; e < term.n_entries; ++e) {
    const TermEntry& entry = term.entries[e];
    if (layout.owns(entry.row)) rhs.row(entry.row) += entry.apply_transposed(force).transpose();
  }
}
}  // namespace

void add_term_forces(const ExtraTerms& terms, const RowLayout& layout, const SchemeCoefficients& c,
                     const Points& displacement, RowsOut rhs) {
  for (const ExtraTerm& term : terms)
    add_force(term,
              -c.sigma *
                  (term.gradient + term.hessian * term.relative_displacement(displacement, c.time)),
              layout, rhs);
}

void add_term_gradients(const ExtraTerms& terms, const RowLayout& layout, double sigma,
                        RowsOut rhs) {
  for (const ExtraTerm& term : terms) add_force(term, -sigma * term.gradient, layout, rhs);
}

}  // namespace loomstone
