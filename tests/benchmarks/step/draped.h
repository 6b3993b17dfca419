// Cloth for the measurements of the implicit step: the square of scenes/drape.py, draped over a
// sphere of radius 0.15 m. Edge 0.5 m, weft and warp stiffness 300 N/m, shear stiffness 150 N/m,
// density 0.3 kg/m^2, bending stiffness 1e-5 N m.
#pragma once

#include "core/sim/scene/scene.h"

namespace loomstone {

// The draped square of `cells` x `cells` cells. A simulation with collisions on a coarse mesh
// gives the shape, bicubic interpolation in uv transfers it to the mesh of this square, and a few
// more steps let this mesh form its own strains and folds.
struct Draped {
  TriangleMesh mesh;  // vertices: the draped shape; uv: the flat pattern
  Points velocities;  // [m/s]
};
Draped drape(Index cells);

// Scene with the draped cloth alone, without collisions.
Scene draped_scene(const Draped& draped);

}  // namespace loomstone
