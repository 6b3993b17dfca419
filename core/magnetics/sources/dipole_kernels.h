// The innermost sums of core/magnetics/sources/dipoles.cpp: dipoles (k x 3) by rows, observers by
// columns x[n], y[n], z[n] with n a multiple of 8.
#pragma once

#include "core/base/types.h"

namespace loomstone {

void dipole_field_block(const double* positions, const double* moments, Index dipoles,
                        const double* points, Index n, double* field);
void dipole_gradient_block(const double* positions, const double* moments, Index dipoles,
                           const double* points, Index n, double* gradient);
// own: moments of the observers, by columns as well; pairs nearer than the root of nearest2 [m^2]
// as in dipole_forces().
void dipole_force_block(const double* positions, const double* moments, Index dipoles,
                        const double* points, const double* own, Index n, double nearest2,
                        double* field, double* force);

}  // namespace loomstone
