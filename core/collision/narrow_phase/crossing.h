// Lower bound on the relative motion that two edges need before they can cross.
#pragma once

#include "core/collision/narrow_phase/distance.h"

namespace loomstone {

// Returns a lower bound on the distance [m] by which points of two edges must move relative to each
// other before the closest points can lie inside both edges and be closer than `thickness` [m]. The
// bound is 0 if the closest points lie inside both edges.
double motion_to_cross(const FourPoints& edges, double thickness);

}  // namespace loomstone
