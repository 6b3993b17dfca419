// Points of a mesh with texture coordinates (u, v), for viewers. A vertex on a seam of the texture
// has several pairs (u, v), and viewers need one point for each pair.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct TexturePoints {
  bool textured = false;        // false: too many seams; `uv` is empty
  Triangles triangles;          // (m x 3) point of each corner
  std::vector<Index> vertices;  // (points) vertex of each point; point i < n_vertices is vertex i
  Points2 uv;                   // (points x 2) texture coordinates [m]
};

// Makes a point for each vertex, followed by a point for each further pair (u, v) of a vertex. If
// there would be more than two points per vertex on average, the texture coordinates are
// discontinuous at many edges. The result is then not textured, and its points are the vertices.
TexturePoints texture_points(Index n_vertices, const Triangles& triangles,
                             const Points2& corner_uv);

}  // namespace loomstone
