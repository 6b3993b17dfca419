// The rules a triangle mesh must keep, checked once when it is made.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Throws InvalidInput naming the first item that breaks a rule.
void check_surface(const Points& vertices, const Triangles& triangles);
// Rest coordinates of an already checked surface. Triangles whose uv agree along a common edge form
// a panel; a panel may be mirrored as a whole (negative area throughout), but a triangle turned
// against the rest of its panel is refused.
void check_rest_coordinates(const Triangles& triangles, const Points2& uv,
                            const Triangles& uv_triangles);

}  // namespace loomstone
