// The cloth on which the implicit step is measured: the square of the drape scene (0.5 m,
// 300/300/150 N/m, 0.3 kg/m^2, 1e-5 N m) at rest on its sphere of radius 0.15 m.
#pragma once

#include "core/sim/scene/scene.h"

namespace loomstone {

// Shape at rest of the square with cells x cells cells: simulated with collisions on a coarse mesh,
// carried over to the fine one by bicubic interpolation in uv, and simulated there for a few more
// steps, so that strains and folds are its own.
struct Draped {
  TriangleMesh mesh;  // vertices: the draped shape; uv: the flat pattern
  Points velocities;  // [m/s]
};
Draped drape(Index cells);

// The draped cloth alone, free of collisions.
Scene draped_scene(const Draped& draped);

}  // namespace loomstone
