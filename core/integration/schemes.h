// The families behind make_integrator.
#pragma once

#include <memory>

#include "core/integration/integrator.h"
#include "core/integration/scheme.h"

namespace loomstone {

std::unique_ptr<Integrator> make_explicit(bool symplectic, const ClothModel& model,
                                          Elasticity& elasticity);
// The scheme is semi-implicit where it is backward Euler.
std::unique_ptr<Integrator> make_linearised(Scheme scheme, const ImplicitOptions& options,
                                            const ClothModel& model, Elasticity& elasticity);
// `name` for messages.
std::unique_ptr<Integrator> make_newton(Scheme scheme, std::string_view name,
                                        const NewtonOptions& options, const ClothModel& model,
                                        Elasticity& elasticity);

// Start values of fixed rows: velocity that leads to the target, 0 for rows that stay.
void prescribe_velocities(const StepInputs& inputs, const Points& x, Points& v);
// Fixed rows end exactly at their target.
void place_fixed(const StepInputs& inputs, Points& x);

// Adds to the owned rows of `rhs` the terms' share -sigma J^T (g + H d), d = sum J displacement -
// time * drift, with sigma and time those of the scheme.
void add_term_forces(const ExtraTerms& terms, const RowLayout& layout, const SchemeCoefficients& c,
                     const Points& displacement, Points& rhs);

// The same for terms whose g is already that of where forces are evaluated.
void add_term_gradients(const ExtraTerms& terms, const RowLayout& layout, double sigma,
                        Points& rhs);

}  // namespace loomstone
