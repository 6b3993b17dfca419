// Checks of the options, topology, frames and colour ranges that users pass to the renderer. Each
// throws InvalidInput for the first error that it finds. Curves are checked in tubes.cpp.
#pragma once

#include "renderer/renderer.h"

namespace loomstone {

void check_options(const RenderOptions& options, int most_samples, int most_pixels);
void check_topology(const FrameTopology& topology);
void check_hidden(const FrameTopology& topology, const RenderOptions& options);
void check_frame(const FrameTopology& topology, const RenderOptions& options, const Frame& frame);
void check_values(std::size_t rows, const std::vector<ColorRange>* values);

}  // namespace loomstone
