// Factories of the integrators, and functions that the schemes share.
#pragma once

#include <memory>

#include "core/integration/integrator.h"
#include "core/integration/scheme_coefficients.h"

namespace loomstone {

std::unique_ptr<Integrator> make_explicit(bool symplectic, const ClothModel& model,
                                          Elasticity& elasticity);
std::unique_ptr<Integrator> make_asynchronous(const Asynchronous& options, const ClothModel& model,
                                              Elasticity& elasticity);
// Makes a linearised integrator. Scheme::BackwardEuler gives semi-implicit Euler.
std::unique_ptr<Integrator> make_linearised(Scheme scheme, const ImplicitOptions& options,
                                            const ClothModel& model, Elasticity& elasticity);
// Makes a Newton integrator. `name` is the name of the scheme in messages.
std::unique_ptr<Integrator> make_newton(Scheme scheme, std::string_view name,
                                        const NewtonOptions& options, const ClothModel& model,
                                        Elasticity& elasticity);

// Refreshes all rows of a table of cloth vertices from the ranks that own them. `wide` is scratch
// memory.
void gather_cloth_rows(const RowLayout& layout, Points& table, Points& wide);
// Sets the velocities of prescribed vertices so that they reach their targets at the end of the
// step.
void prescribe_velocities(const StepInputs& inputs, const Points& x, Points& v);
// Sets the positions of prescribed vertices exactly to their targets.
void place_fixed(const StepInputs& inputs, Points& x);

// Adds the forces of the terms, -J^T (g + H s), times sigma to the owned rows of `rhs`. J, g, H and
// the relative displacement s of a term are defined in extra_terms.h. s is evaluated at the time
// c.time after the start of the step, for the given displacement of the rows.
void add_term_forces(const ExtraTerms& terms, const RowLayout& layout, const SchemeCoefficients& c,
                     const Points& displacement, RowsOut rhs);

// Adds -sigma J^T g to the owned rows of `rhs`. The gradients g (see extra_terms.h) must already
// include the effect of the motion of the rows.
void add_term_gradients(const ExtraTerms& terms, const RowLayout& layout, double sigma,
                        RowsOut rhs);

}  // namespace loomstone
