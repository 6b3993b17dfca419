// The view of a camera: position, axes, field of view, and the matrices that follow from them.
#pragma once

#include "renderer/framing.h"
#include "renderer/gl_objects.h"

namespace loomstone {

// Position [m], axes and field of view of the camera. Axes are unit vectors; `forward` points into
// the picture.
struct View {
  Vec3 eye, right, up, forward;
  double tangent_x, tangent_y;   // tangents of half the angles of view
  double near_depth, far_depth;  // depths of the clipping planes [m]
  Float4x4 view() const;         // world to eye coordinates
  Float4x4 projection() const;
};

// Returns the view at a time of the run [s]. `aspect` is width / height of the picture. On each
// side, a fitted camera leaves at least the fraction `legend` of the width empty.
View make_view(const Camera& camera, double aspect, const Framing& framing, double time = 0.0,
               double legend = 0.0);

// Returns the unit vector from the target to the eye. If the two coincide, the vector points to the
// right (x), to the front (-y) and upwards (z).
Vec3 viewing_direction(const Camera& camera);

// Returns whether make_view() moves the eye so that all points of the framing are visible.
inline bool fits(const Camera& camera) { return camera.fit && camera.times.empty(); }

}  // namespace loomstone
