// Pairs of triangles of one configuration that intersect, by exact predicates; independent of all
// that keeps surfaces apart, so that it can judge the rest.
#pragma once

#include <array>
#include <vector>

#include "core/collision/model/collision_model.h"

namespace loomstone {

// Pairs that intersect and share no vertex, ascending.
std::vector<std::array<Index, 2>> intersecting_pairs(const Points& points,
                                                     const Triangles& triangles);
// Those of them that certification keeps apart: at least one is cloth; a cloth without
// self-collision is not held against itself.
std::vector<std::array<Index, 2>> cloth_intersections(const CollisionModel& model,
                                                      const Points& points);

}  // namespace loomstone
