// Estimates the errors that the approximate surface charge of induced bodies causes in forces, from
// the forces on the estimated errors of the charge.
#pragma once

#include <vector>

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Returns the error of the force that `by` exerts on `on`, or of torque / radius of `on` if that is
// larger [N]. It is 0 if neither body is induced, and NaN if a charge has no estimated error.
double charge_error(const MagneticBody& on, const MagneticBody& by);
// Returns the sum of the errors of the forces from all other bodies, for each body (n) [N].
Vector charge_errors(const Team& team, const std::vector<MagneticBody>& bodies);

}  // namespace loomstone
