// Validation of triangle meshes, done once when a mesh is created.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Checks the vertices and triangles of a surface. Throws InvalidInput for the first violation of
// the rules that triangle_mesh.h lists.
void check_surface(const Points& vertices, const Triangles& triangles);
// Checks the rest coordinates (uv) of a valid surface. Triangles whose uv agree along a common edge
// form a panel. A panel may be mirrored as a whole (negative areas). Throws InvalidInput for
// invalid arrays, and for a triangle that has zero area in uv or is inverted relative to its panel.
void check_rest_coordinates(const Triangles& triangles, const Points2& uv,
                            const Triangles& uv_triangles);

}  // namespace loomstone
