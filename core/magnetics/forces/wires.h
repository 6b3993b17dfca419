// Detection of thin wires that meet. The force between two infinitely thin wires can grow without
// bound as they approach each other.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Returns whether two thin wires (loops or polylines) come closer to each other than 1e-6 of the
// sum of their radii (Source::radius()). Returns false if either source is not a thin wire.
bool wires_meet(const MagneticBody& a, const MagneticBody& b);

}  // namespace loomstone
