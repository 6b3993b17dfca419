// Cloth for the measurements of the implicit step: the square of the drape scene (0.5 m,
// 300/300/150 N/m, 0.3 kg/m^2, 1e-5 N m) at rest on its sphere of radius 0.15 m.
#pragma once

#include "core/sim/scene/scene.h"

namespace loomstone {

// The square of `cells` x `cells` cells at rest. A simulation with collisions on a coarse mesh
// gives the shape, bicubic interpolation in uv transfers it to the fine mesh, and a few more steps
// there let the fine mesh form its own strains and folds.
struct Draped {
  TriangleMesh mesh;  // vertices: the draped shape; uv: the flat pattern
  Points velocities;  // [m/s]
};
Draped drape(Index cells);

// Scene with the draped cloth alone, without collisions.
Scene draped_scene(const Draped& draped);

}  // namespace loomstone
