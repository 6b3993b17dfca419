// Intersecting pairs of triangles of one configuration, by exact predicates. Independent of the
// collision response, so that tests can judge it.
#pragma once

#include <array>
#include <vector>

#include "core/collision/model/collision_model.h"

namespace loomstone {

// Pairs that intersect and share no vertex, ascending.
std::vector<std::array<Index, 2>> intersecting_pairs(const Points& points,
                                                     const Triangles& triangles);
// Those of them that certification prevents: at least one triangle is cloth, and a cloth without
// self-collision does not count against itself.
std::vector<std::array<Index, 2>> cloth_intersections(const CollisionModel& model,
                                                      const Points& points);

}  // namespace loomstone
