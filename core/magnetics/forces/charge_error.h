// Estimated errors of forces between an induced body, whose surface charge is approximate, and
// another body. They are derived from the force that the field of the other body would exert on a
// charge equal to the estimated error of the induced charge.
#pragma once

#include <vector>

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Returns the estimated error of the force that `by` exerts on `on`, or of the torque divided by
// the radius of `on` if that error is larger [N]. The radius of `by` is used if `on` is a single
// dipole at its origin, whose radius is 0. The result is 0 if neither body is induced, and NaN if
// the charge errors of an induced body are unknown.
double charge_error(const MagneticBody& on, const MagneticBody& by);
// Returns for each body (n) the sum of the charge_error() of the forces that all other bodies exert
// on it [N].
Vector charge_errors(const Team& team, const std::vector<MagneticBody>& bodies);

}  // namespace loomstone
