// Strain limits as a potential. Beyond a limit, the membrane has a stiff second phase and, at
// larger strains, a still stiffer third phase; see LimitMode. Unlike the limit phases of implicit
// steps (limits/limit_phase.h), these phases follow a fixed law, so their forces are conservative.
#pragma once

#include <optional>
#include <vector>

#include "core/cloth/cloth_model.h"

namespace loomstone {

// Returns the modes of each triangle (m). The modes of a limited triangle are weft, warp and shear,
// or its three edges if these are limited. If `bound` is given, it replaces all finite upper limits
// of extension, shear and edge strain. The lower limit of shear is minus the upper one unless
// `shear_min` is given. The modes of a triangle without limits add no energy.
std::vector<LimitModes> limit_potential(const ClothModel& model, std::optional<double> bound);

}  // namespace loomstone
