// Where the magnets of a frame are: for pictures, from the vertices that a frame shows.
#pragma once

#include "core/base/frame.h"
#include "core/magnetics/sources/body.h"
#include "core/parallel/team.h"
#include "core/sim/model/model.h"

namespace loomstone {

// All magnets of the model in the order of the scene, spheres that magnetise as the magnets that
// they are there. Throws InvalidInput where the frame is of another scene.
std::vector<MagneticBody> magnets_of_frame(const Team& team, const Model& model,
                                           const Frame& frame);

}  // namespace loomstone
