// Validation of triangle meshes, done once when a mesh is made.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Throws InvalidInput naming the first item that violates a rule.
void check_surface(const Points& vertices, const Triangles& triangles);
// Checks the rest coordinates of a valid surface. Triangles whose uv agree along a common edge form
// a panel. A panel may be mirrored as a whole (negative area throughout); a triangle inverted
// against the rest of its panel is refused.
void check_rest_coordinates(const Triangles& triangles, const Points2& uv,
                            const Triangles& uv_triangles);

}  // namespace loomstone
