// Synthetic scene for test pictures, from formulas alone: a square cloth with folds lies over a
// ball above a floor.
#pragma once

#include "core/base/frame.h"
#include "renderer/renderer.h"

namespace loomstone {

struct DrapedScene {
  FrameTopology topology;
  Frame frame;
};

// `cells`: squares along each side of the 0.62 m cloth (85: 14,450 triangles). `subdivisions`: of
// the ball's icosahedron (4: 5,120 triangles).
DrapedScene draped_scene(Index cells = 40, int subdivisions = 3);

// A flat vertical square of cloth, 0.5 m wide, without bodies.
DrapedScene flat_scene(Index cells = 8);

// Options for pictures that are smaller and cheaper than the default.
RenderOptions small_options();

std::size_t n_different(const Image& a, const Image& b);

}  // namespace loomstone
