// From a camera description to the matrices of a picture.
#pragma once

#include "core/base/frame.h"
#include "renderer/gl_objects.h"
#include "renderer/renderer.h"

namespace loomstone {

// The region that a fitted camera shows, and the size that shading takes as its scale. Made once,
// from the first frame, so that the picture does not wander while the cloth moves.
struct Framing {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // axis-parallel box [m]
  Vec3 centre() const { return 0.5 * (low + high); }
  double radius() const { return 0.5 * (high - low).norm(); }
};

// The box of cloth and bodies (floors excluded), lowered to where the cloth may still fall: to a
// floor below it, but by no more than the cloth's larger horizontal extent (a sheet held at one
// side swings down by that; our choice).
Framing make_framing(const FrameTopology& topology, const Frame& first);

// Where the camera stands and what it sees. Axes are unit vectors; `forward` points into the
// picture.
struct View {
  Vec3 eye, right, up, forward;
  double tangent_x, tangent_y;   // of half the angles of view
  double near_depth, far_depth;  // [m]
  Float4x4 view() const;         // world to eye
  Float4x4 projection() const;
};

View make_view(const Camera& camera, double aspect, const Framing& framing);

// Direction from the target to the eye, unit length; a camera whose eye is its target looks from
// front right, above.
Vec3 viewing_direction(const Camera& camera);

}  // namespace loomstone
