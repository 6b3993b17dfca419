// Finds intersecting triangles of one configuration by exact predicates. Independent of the
// collision response, so that tests can verify the response.
#pragma once

#include <array>
#include <vector>

#include "core/collision/model/collision_model.h"

namespace loomstone {

// Returns the pairs of triangles that intersect and share no vertex, in ascending order.
std::vector<std::array<Index, 2>> intersecting_pairs(const Points& points,
                                                     const Triangles& triangles);
// As above, but only for pairs that certification keeps apart: at least one triangle is cloth, and
// a cloth with itself counts only if it has self-collision.
std::vector<std::array<Index, 2>> cloth_intersections(const CollisionModel& model,
                                                      const Points& points);

}  // namespace loomstone
