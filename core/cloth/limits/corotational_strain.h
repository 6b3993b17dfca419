// Co-rotational strain U - I, to which limits of weft, warp and shear refer. U comes from the polar
// decomposition F = R U of the deformation gradient. The dimensionless components in weft/warp axes
// are (weft, warp, shear e12).
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/mesh/triangle_mesh.h"
#include "core/parallel/team.h"

namespace loomstone {

// Computes the co-rotational strain from the Green strain (E11, E22, E12) of the same triangle.
Vec3 corotational_strain(const Vec3& green);

// Co-rotational strain of one triangle, with the given rest coordinates, at positions x.
Vec3 corotational_strain(const Triangles& triangles, const Corners2& corners, const Points& x,
                         Index triangle);
// Co-rotational strain of every triangle (m x 3) at positions x.
void corotational_strain(const Team& team, const Triangles& triangles,
                         const std::vector<Corners2>& corners, const Points& x, Points& strain);

}  // namespace loomstone
