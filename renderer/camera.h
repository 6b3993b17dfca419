// Converts a camera description to view and projection matrices.
#pragma once

#include "core/base/frame.h"
#include "renderer/gl_objects.h"
#include "renderer/renderer.h"

namespace loomstone {

// The region that a fitted camera shows. Its radius is the length scale of shading. It is computed
// once, from the first frame, so that the view stays fixed while the cloth moves.
struct Framing {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // axis-aligned box [m]
  Vec3 centre() const { return 0.5 * (low + high); }
  double radius() const { return 0.5 * (high - low).norm(); }
};

// Bounding box of cloth and bodies without floors, extended downwards by the fall of the cloth. The
// fall ends one horizontal extent of the cloth below its top, or at the floor if the floor is
// higher. Our choice: a sheet held at one side swings down by this extent.
Framing make_framing(const FrameTopology& topology, const Frame& first);

// Position, axes and field of view of the camera. Axes are unit vectors; `forward` points into the
// picture.
struct View {
  Vec3 eye, right, up, forward;
  double tangent_x, tangent_y;   // tangents of half the angles of view
  double near_depth, far_depth;  // [m]
  Float4x4 view() const;         // world to eye coordinates
  Float4x4 projection() const;
};

View make_view(const Camera& camera, double aspect, const Framing& framing);

// Unit vector from target to eye. If the two coincide, the camera looks from the front right and
// from above.
Vec3 viewing_direction(const Camera& camera);

}  // namespace loomstone
