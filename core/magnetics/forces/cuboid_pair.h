// Force and torque between two uniformly magnetised cuboids with parallel edges, in closed form
// [Akoun1984], [Janssen2010]. They are sums over 8 x 8 pairs of corners. Each term is a function of
// the vector between the two corners. A term of the torque also depends on the position of the
// corner of the cuboid on which the torque acts, relative to the centre of this cuboid.
#pragma once

#include <optional>

#include "core/magnetics/forces/interaction.h"

namespace loomstone {

// Returns the wrench on `on` exerted by `by` if both bodies are uniformly magnetised cuboids and
// their edges are parallel to within 1e-12 rad, and otherwise no value. Wrench::error estimates the
// rounding error of the sums.
std::optional<Wrench> parallel_cuboid_wrench(const MagneticBody& on, const MagneticBody& by);

}  // namespace loomstone
