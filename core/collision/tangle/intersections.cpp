#include "core/collision/tangle/intersections.h"

#include <algorithm>

#include "core/collision/broad_phase/median_tree.h"
#include "core/collision/narrow_phase/exact_predicates.h"

namespace loomstone {

std::vector<std::array<Index, 2>> intersecting_pairs(const Points& points,
                                                     const Triangles& triangles) {
  const std::vector<Box> boxes = triangle_boxes(points, triangles);
  const auto corner = [&](Index t, int k) { return Vec3(points.row(triangles(t, k)).transpose()); };
  std::vector<std::array<Index, 2>> found;
  MedianTree(boxes).each_pair([&](Index i, Index j) {
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
        if (triangles(i, k) == triangles(j, l)) return;
    if (triangles_meet(corner(i, 0), corner(i, 1), corner(i, 2), corner(j, 0), corner(j, 1),
                       corner(j, 2)))
      found.push_back({std::min(i, j), std::max(i, j)});
  });
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::array<Index, 2>> cloth_intersections(const CollisionModel& model,
                                                      const Points& points) {
  auto pairs = intersecting_pairs(points, model.triangles);
  std::erase_if(pairs, [&](const std::array<Index, 2>& pair) {
    return !kept_apart(model, model.surface_of_triangle(pair[0]),
                       model.surface_of_triangle(pair[1]));
  });
  return pairs;
}

}  // namespace loomstone
