// Test whether a straight path crosses a triangle. Independent of Bullet.
#pragma once

#include <array>
#include <optional>

#include "core/base/types.h"

namespace loomstone {

// Returns the fraction of the path [1] that lies before the plane of the triangle, if the path
// crosses this plane inside the triangle or on its boundary. A path that crosses a surface at an
// edge between two triangles crosses at least one of them, in spite of rounding.
std::optional<double> crossing(const Vec3& from, const Vec3& to,
                               const std::array<Vec3, 3>& triangle);

}  // namespace loomstone
