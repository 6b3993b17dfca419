// The families behind make_integrator.
#pragma once

#include <memory>

#include "core/integration/integrator.h"

namespace loomstone {

std::unique_ptr<Integrator> make_explicit(const IntegratorOptions& options, const ClothModel& model,
                                          Elasticity& elasticity);
std::unique_ptr<Integrator> make_linearised(const IntegratorOptions& options,
                                            const ClothModel& model, Elasticity& elasticity);
std::unique_ptr<Integrator> make_newton(const IntegratorOptions& options, const ClothModel& model,
                                        Elasticity& elasticity);

// Start values of fixed rows: velocity that leads to the target, 0 for rows that stay.
void prescribe_velocities(const StepInputs& inputs, const Points& x, Points& v);
// Fixed rows end exactly at their target.
void place_fixed(const StepInputs& inputs, Points& x);

// Adds to the owned rows of `rhs` the terms' share -sigma J^T (g + H d), d = sum J displacement -
// time * drift, with `time` the part of the step after which the scheme evaluates forces [s].
void add_term_forces(const ExtraTerms& terms, const RowLayout& layout, double sigma, double time,
                     const Points& displacement, Points& rhs);

// The same for terms whose g is already that of where forces are evaluated.
void add_term_gradients(const ExtraTerms& terms, const RowLayout& layout, double sigma,
                        Points& rhs);

}  // namespace loomstone
