#include "core/collision/model/feature_pairs.h"

#include <cmath>

namespace loomstone {

std::vector<SurfacePair> surface_pairs(const CollisionModel& model) {
  using Kind = CollisionSurface::Kind;
  std::vector<SurfacePair> pairs;
  const Index n = static_cast<Index>(model.surfaces.size());
  for (Index a = 0; a < n; ++a)
    for (Index b = a; b < n; ++b) {
      const CollisionSurface &first = model.surfaces[a], &second = model.surfaces[b];
      if (first.kind != Kind::Cloth && second.kind != Kind::Cloth) continue;
      if (a == b && !first.self_collision) continue;
      const bool turned = first.kind != Kind::Cloth;
      pairs.push_back({turned ? b : a, turned ? a : b, 0.5 * (first.thickness + second.thickness),
                       std::sqrt(first.friction * second.friction)});
    }
  return pairs;
}

}  // namespace loomstone
