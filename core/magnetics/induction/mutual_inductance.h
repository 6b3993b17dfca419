// Mutual inductance of coils: the flux of one's field through the other, as the integral of the
// vector potential along the winding, which stays finite where coils lie in or on one another.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// [H] of loops and solenoids, each with its turns and one ampere, to `tolerance` times the integral
// of the potential's absolute value along the winding (where windings touch, 1e-5 of it). Throws
// InvalidInput for other sources.
double mutual_inductance(const MagneticBody& a, const MagneticBody& b, double tolerance);

}  // namespace loomstone
