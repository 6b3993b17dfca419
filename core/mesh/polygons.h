// Splits polygons into triangles.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Returns the triangles of a polygon, three corner numbers each, with the orientation of the
// polygon. If all triangles of the fan about the first corner have an area and do not overlap, or
// if none has an area, returns the fan; otherwise, cuts off ears one by one [Meisters1975]. The
// polygon need not be exactly flat. If its outline crosses itself, the result is meaningless or, in
// most cases, empty.
std::vector<std::array<int, 3>> split_polygon(const std::vector<Vec3>& corners);

// Returns the triangles of several polygons as row indices of `corners` (c x 3). Polygon p has the
// corners start[p] to start[p + 1] - 1. A polygon with fewer than three corners has no triangles.
// Throws InvalidInput if `start` decreases or has an entry outside [0, c], or if split_polygon()
// returns no triangles for three or more corners.
Triangles split_polygons(const Points& corners, const std::vector<Index>& start);

}  // namespace loomstone
