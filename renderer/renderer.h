// Headless rendering of frames. The OpenGL library is chosen at run time; see context.h.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/frame.h"
#include "renderer/image.h"
#include "renderer/render_options.h"

namespace loomstone {

// Curves drawn as tubes, stored one after another.
struct Curves {
  Points points;             // (n x 3) [m]
  std::vector<Index> first;  // (curves + 1) first row of each curve in `points`, then n
  Vector value;              // (n) colour: 1 red, 0 yellow, -1 blue
  double radius = 0.0;       // radius of the tubes [m]
};

struct ColorRange {
  double low, high;
};

class Renderer {
 public:
  // `table` contains the colours of fields. If `diverging` is true, the automatic range of every
  // field except contact is centred on the neutral value of the field. Throws InvalidInput for an
  // invalid topology, option or value of the environment variable LOOMSTONE_GL (see context.h), and
  // Unsupported if no OpenGL library is usable.
  Renderer(const FrameTopology& topology, const RenderOptions& options,
           const ColorTable& table = grey_table(), bool diverging = false);
  ~Renderer();
  // Determines from the given frame the length scale of shading, the sharp edges of bodies, and the
  // region that a fitted camera shows. If fit() is called with the first frame of a sequence,
  // pictures do not depend on the frames that were drawn before. If fit() is not called, the first
  // rendered frame is used.
  void fit(const Frame& first);
  // Returns value_range() (see scalar_field.h) in a frame for each field that color_by names (one
  // for each row of the picture); 0 to 0 for "cloth".
  std::vector<ColorRange> value_ranges(const Frame& frame) const;
  // Returns color_range() (see scalar_field.h) in a frame for each field that color_by names (one
  // for each row of the picture); 0 to 0 for "cloth". `values` has the same meaning as in render().
  std::vector<ColorRange> color_ranges(const Frame& frame,
                                       const std::vector<ColorRange>* values = nullptr) const;
  // Draws a frame. For each field that color_by names, `values` contains the range of values that
  // determines automatic colours, for example over all frames of a run. If `values` is null, that
  // range is value_range() in this frame. Only one thread at a time may use a Renderer, but several
  // Renderers may exist at once.
  Image render(const Frame& frame, const Curves* curves = nullptr,
               const std::vector<ColorRange>* values = nullptr);
  // Returns the depth, normal and number of the surface at each pixel, without anti-aliasing.
  SurfaceImages surfaces(const Frame& frame, const Curves* curves = nullptr);
  const std::string& backend() const;  // "osmesa" | "egl" | "softpipe"

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
