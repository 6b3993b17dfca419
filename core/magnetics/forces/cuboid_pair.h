// Force and torque between two cuboids whose edges are parallel, in closed form [Akoun1984],
// [Janssen2010]: sums over the 8 x 8 corners of functions of the arms between them.
#pragma once

#include <optional>

#include "core/magnetics/forces/interaction.h"

namespace loomstone {

// On `on` by `by`, with the rounding of the sums as error; none where the two are no cuboids or not
// parallel to 1e-12.
std::optional<Wrench> parallel_cuboid_wrench(const MagneticBody& on, const MagneticBody& by);

}  // namespace loomstone
