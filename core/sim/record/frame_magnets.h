// The magnets of a frame, placed by the vertices that the frame shows; for pictures.
#pragma once

#include "core/base/frame.h"
#include "core/magnetics/sources/body.h"
#include "core/parallel/team.h"
#include "core/sim/model/model.h"

namespace loomstone {

// All magnets of the model in the order of the scene. Spheres that magnetise stand as the magnets
// that they are in that frame. Throws InvalidInput where the frame is of another scene.
std::vector<MagneticBody> magnets_of_frame(const Team& team, const Model& model,
                                           const Frame& frame);

}  // namespace loomstone
