// Synthetic scene for test pictures, computed from formulas alone: a square cloth with folds hangs
// over a ball above a floor.
#pragma once

#include "core/base/frame.h"
#include "renderer/renderer.h"

namespace loomstone {

struct DrapedScene {
  FrameTopology topology;
  Frame frame;
};

// The cloth is a square of 0.62 m with `cells` cells along each side; 85 cells give 14,450
// triangles. The ball is a subdivided icosahedron; 4 subdivisions give 5,120 triangles.
DrapedScene draped_scene(Index cells = 40, int subdivisions = 3);

// A flat vertical square of cloth, 0.5 m wide, without bodies.
DrapedScene flat_scene(Index cells = 8);

// Options for pictures that are smaller and cheaper than those with the default options.
RenderOptions small_options();

std::size_t n_different(const Image& a, const Image& b);

}  // namespace loomstone
