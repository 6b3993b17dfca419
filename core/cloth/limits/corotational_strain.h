// The strain that limits are stated in, U - I of the polar decomposition F = R U of the deformation
// gradient, in weft/warp axes: (weft, warp, shear e12) [1].
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/mesh/triangle_mesh.h"
#include "core/parallel/team.h"

namespace loomstone {

// From the Green strain (E11, E22, E12) of the same triangle.
Vec3 corotational_strain(const Vec3& green);

// The strain of one triangle at positions x.
Vec3 corotational_strain(const Triangles& triangles, const std::vector<Corners2>& corners,
                         const Points& x, Index triangle);
// The strain of every triangle (m x 3).
void corotational_strain(const Team& team, const Triangles& triangles,
                         const std::vector<Corners2>& corners, const Points& x, Points& strain);

}  // namespace loomstone
