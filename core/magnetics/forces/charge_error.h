// Estimated errors of the forces on and from induced bodies, whose surface charge is approximate.
// They are derived from the forces on the estimated errors of the charge.
#pragma once

#include <vector>

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Returns the estimated error of the force that `by` exerts on `on`, or of the torque divided by
// the radius of `on` if that is larger [N]. It is 0 if neither body is induced, and NaN if the
// errors of a charge are unknown.
double charge_error(const MagneticBody& on, const MagneticBody& by);
// Returns for each body the sum of charge_error() over all other bodies (n) [N].
Vector charge_errors(const Team& team, const std::vector<MagneticBody>& bodies);

}  // namespace loomstone
