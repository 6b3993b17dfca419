// Validates everything that users pass to the renderer. Throws InvalidInput for the first
// violation.
#pragma once

#include "renderer/renderer.h"

namespace loomstone {

void check_options(const RenderOptions& options, int most_samples, int most_pixels);
void check_topology(const FrameTopology& topology);
void check_hidden(const FrameTopology& topology, const RenderOptions& options);
void check_frame(const FrameTopology& topology, const RenderOptions& options, const Frame& frame);
void check_values(std::size_t rows, const std::vector<ColorRange>* values);

}  // namespace loomstone
