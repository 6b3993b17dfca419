#include "core/collision/model/feature_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

double attached_distance(const CollisionModel& model, ContactKind kind,
                         const std::array<Index, 4>& vertices) {
  double least = std::numeric_limits<double>::infinity();
  if (model.attached.empty()) return least;
  const int n_a = kind == ContactKind::VertexFace ? 1 : 2;
  const Index of_a = model.surface_of_vertex(vertices[0]),
              of_b = model.surface_of_vertex(vertices[3]);
  for (int i = 0; i < 4; ++i) {
    const AttachedTo& attached = model.attached[vertices[i]];
    if (attached.surface == (i < n_a ? of_b : of_a)) least = std::min(least, attached.distance);
  }
  return least;
}

double contact_distance(const CollisionModel& model, const SurfacePair& pair, ContactKind kind,
                        const std::array<Index, 4>& vertices) {
  return std::min(pair.thickness, attached_distance(model, kind, vertices));
}

}  // namespace loomstone
