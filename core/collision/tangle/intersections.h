// Finds intersecting triangles of one configuration by exact predicates. The search does not depend
// on the collision response, so tests can use it to verify the response.
#pragma once

#include <array>
#include <vector>

#include "core/collision/model/collision_model.h"

namespace loomstone {

// Returns the pairs of triangles that intersect and share no vertex, in ascending order.
std::vector<std::array<Index, 2>> intersecting_pairs(const Points& points,
                                                     const Triangles& triangles);
// Like intersecting_pairs(), but only for triangles of surfaces that must not intersect; see
// kept_apart(). At least one triangle of such a pair is cloth. Pairs of a cloth with itself count
// only if it has self-collision.
std::vector<std::array<Index, 2>> cloth_intersections(const CollisionModel& model,
                                                      const Points& points);

}  // namespace loomstone
