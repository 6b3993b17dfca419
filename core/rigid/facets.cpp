#include "core/rigid/facets.h"

#include <algorithm>

#include "core/rigid/bullet_engine.h"
#include "core/rigid/shape_geometry.h"

namespace loomstone {

Mat3 Facet::at(const Points& x) const {
  return (Mat3() << x.row(around.corners[0]), x.row(around.corners[1]), x.row(around.corners[2]))
      .finished();
}

void Facet::put(btRigidBody& body, const Points& x) const {
  const FacetFrame frame = facet_frame(at(x));
  shape->setMargin(0.0);
  for (int k = 0; k < 3; ++k)
    shape->m_vertices1[k] = to_bullet(Vec3(frame.corners.row(k).transpose()));
  set_pose(body, btTransform(to_bullet(frame.axes), to_bullet(frame.centre)));
}

void add_facets(const RigidObstacle& obstacle, Index first, const Points& vertices,
                std::vector<Facet>& facets) {
  const Triangles& triangles = obstacle.mesh->triangles();
  // The triangles at each vertex of the obstacle.
  std::vector<std::vector<std::array<Index, 3>>> at(obstacle.vertices.rows());
  for (const auto& t : triangles.rowwise())
    for (const Index corner : t) at[corner].push_back({t[0] + first, t[1] + first, t[2] + first});
  for (const auto& t : triangles.rowwise()) {
    const std::array<Index, 3> corners = {t[0] + first, t[1] + first, t[2] + first};
    std::vector<std::array<Index, 3>> others;
    const auto add = [&](const std::array<Index, 3>& other) {
      if (other != corners && std::find(others.begin(), others.end(), other) == others.end())
        others.push_back(other);
    };
    for (const Index corner : t) std::for_each(at[corner].begin(), at[corner].end(), add);
    facets.push_back({{&vertices, corners, std::move(others)}, obstacle.friction});
  }
}

}  // namespace loomstone
