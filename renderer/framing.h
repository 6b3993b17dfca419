// The region that a fitted camera shows, and cameras that are fitted to several frames.
#pragma once

#include <vector>

#include "core/base/frame.h"
#include "renderer/render_options.h"

namespace loomstone {

// The region that a fitted camera shows. Its radius is the length scale of shading. A renderer
// computes the region once, usually from the first frame, so that it stays the same while the cloth
// moves.
struct Framing {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // axis-aligned box [m]
  // Points that must be visible [m]; empty: the corners of the box.
  std::vector<Vec3> points = {};
  Vec3 centre() const { return 0.5 * (low + high); }
  double radius() const { return 0.5 * (high - low).norm(); }
};

// Returns the region of the cloth and of visible bodies and obstacles other than floors, extended
// downwards to the height to which the cloth is expected to fall. This is the height of the highest
// floor or, if greater, that of the top of the cloth minus the larger horizontal extent of the
// cloth: a sheet pinned at one side falls that far.
Framing make_framing(const FrameTopology& topology, const Frame& first);

// Returns the width that the legend of a field takes at the right edge of a picture that is
// `height` pixels high [pixels].
double legend_width(int height);
// Returns the width of the legend as a fraction of the width of the picture, at most 0.3, or 0 if
// no field is drawn.
double legend_share(const RenderOptions& options);

// Finds a camera that shows cloth, bodies and obstacles of several frames as large as possible
// beside the legend. Floors and all hidden bodies and obstacles are left out.
class CameraFit {
 public:
  // Throws InvalidInput for an invalid topology or options, or if the camera has keyframes.
  CameraFit(const FrameTopology& topology, const RenderOptions& options);
  void include(const Frame& frame);
  // Returns the camera at its fitted position, with Camera::fit switched off. At least one frame
  // must have been included.
  Camera camera() const;

 private:
  FrameTopology topology_;
  Camera camera_;
  double aspect_, legend_;  // see make_view()
  // The box is that of the first included frame, and a camera turns about its centre. The points
  // are the outermost points of all included frames.
  Framing framing_;
};

}  // namespace loomstone
