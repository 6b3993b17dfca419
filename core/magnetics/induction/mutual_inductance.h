// Mutual inductance of two coils: the flux through coil 1 per ampere in coil 2, computed as the
// integral of the vector potential of coil 2 along the winding of coil 1. The integral is finite
// even if the coils overlap or touch, except for two loops that coincide.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Returns the mutual inductance [H] of two loops or solenoids, given as sources with one ampere per
// turn. The estimated error is at most `tolerance` times the value of the integral with the norm of
// the vector potential in place of its tangential component. The error can be larger if the finest
// quadrature does not suffice, for example because the windings touch. Throws InvalidInput for
// other sources and for loops that coincide.
double mutual_inductance(const MagneticBody& a, const MagneticBody& b, double tolerance);

}  // namespace loomstone
