// A made-up picture to look at: square cloth lying over a ball above a floor, with folds, from
// formulas alone.
#pragma once

#include "core/base/frame.h"
#include "renderer/renderer.h"

namespace loomstone {

struct DrapedScene {
  FrameTopology topology;
  Frame frame;
};

// `cells` squares along each side of the 0.5 m cloth (85: 14,450 triangles); `subdivisions` of the
// ball's icosahedron (4: 5,120 triangles).
DrapedScene draped_scene(Index cells = 40, int subdivisions = 3);

// The ball alone over the floor, and a flat square of cloth hung across the view.
DrapedScene flat_scene(Index cells = 8);

// A smaller, cheaper picture than the default.
RenderOptions small_options();

// Number of pixels that differ.
std::size_t n_different(const Image& a, const Image& b);

}  // namespace loomstone
