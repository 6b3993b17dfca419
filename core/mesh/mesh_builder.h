// Argument checks for the generators, and the arrays in which they build a mesh.
#pragma once

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/message.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

inline void require_positive(double value, const char* name) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    fail<InvalidInput>("{} must be > 0 and finite [m], got {}; give a length in metres", name,
                       value);
  }
}

inline void require_between(Index count, Index low, Index high, const char* name) {
  if (count < low || count > high) {
    fail<InvalidInput>("{} must be {} to {}, got {}; choose another number", name, low, high,
                       count);
  }
}

// Arrays of a mesh under construction.
struct MeshBuilder {
  std::vector<Vec3> vertices;
  std::vector<std::array<Index, 3>> triangles;

  Index add(const Vec3& vertex) {
    vertices.push_back(vertex);
    return static_cast<Index>(vertices.size()) - 1;
  }
  void add(Index a, Index b, Index c) { triangles.push_back({a, b, c}); }

  TriangleMesh mesh() const {
    Points points(static_cast<Eigen::Index>(vertices.size()), 3);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      points.row(static_cast<Eigen::Index>(i)) = vertices[i].transpose();
    Triangles faces(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      faces.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1], triangles[t][2];
    }
    return TriangleMesh(std::move(points), std::move(faces));
  }
};

}  // namespace loomstone
