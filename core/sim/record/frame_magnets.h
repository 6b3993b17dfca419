// Magnets of a frame for rendering. Their poses are fitted to the frame's vertices.
#pragma once

#include "core/base/frame.h"
#include "core/magnetics/sources/body.h"
#include "core/parallel/team.h"
#include "core/sim/model/model.h"

namespace loomstone {

// Returns all magnets of the model in the order of the scene, then the coils that carry current.
// Soft-magnetic bodies have the magnetisation that is induced in this frame. Throws InvalidInput
// unless the frame has as many vertices of bodies and obstacles as the model.
std::vector<MagneticBody> magnets_of_frame(const Team& team, const Model& model,
                                           const Frame& frame);

}  // namespace loomstone
