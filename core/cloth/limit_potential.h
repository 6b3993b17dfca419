// Strain limits as a potential: stiff phases of the membrane beyond each limit. Unlike the phases
// of implicit steps (limits/limit_phase.h) they are a fixed law, whose energy explicit steps keep.
#pragma once

#include <optional>
#include <vector>

#include "core/cloth/cloth_model.h"

namespace loomstone {

// Modes of each triangle (m). A limited triangle has the modes weft, warp and shear, or its edges
// if these are limited. `bound` replaces all limits of extension and shear that are finite. A
// triangle without limits has modes that add no energy.
std::vector<LimitModes> limit_potential(const ClothModel& model, std::optional<double> bound);

}  // namespace loomstone
