// Force and torque between two cuboids with parallel edges, in closed form [Akoun1984],
// [Janssen2010]: sums over 8 x 8 pairs of corners of functions of the arms between them.
#pragma once

#include <optional>

#include "core/magnetics/forces/interaction.h"

namespace loomstone {

// Exerted on `on` by `by`; the error is the rounding of the sums. No value if either is not a
// cuboid or if their edges are not parallel to 1e-12.
std::optional<Wrench> parallel_cuboid_wrench(const MagneticBody& on, const MagneticBody& by);

}  // namespace loomstone
