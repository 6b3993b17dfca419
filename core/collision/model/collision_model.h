// All surfaces that may touch, concatenated in one vertex array: cloth first (in the order of the
// cloth rows), then rigid bodies, then obstacles. Constant after construction.
#pragma once

#include <string>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct CollisionSurface {
  enum class Kind { Cloth, Body, Script };
  std::string name;
  Kind kind = Kind::Cloth;
  Index first_vertex = 0, n_vertices = 0;
  Index first_triangle = 0, n_triangles = 0;
  double thickness = 1e-3;     // contact distance to itself [m]; a pair of surfaces takes the mean
  double friction = 0.3;       // coefficient [1]; a pair of surfaces takes the geometric mean
  bool self_collision = true;  // cloth only
  int body = -1;               // index of the rigid body (Kind::Body)
  bool smooth =
      false;  // contact normals are interpolated from vertex normals; edges carry no force
};

// Rows of the linear system that move each collision vertex.
struct VertexRows {
  std::vector<Index> row;  // cloth row, or translation row of its body; -1: prescribed motion
  std::vector<std::uint8_t> is_body;
};

struct CollisionModel {
  Index n_vertices = 0;
  Triangles triangles;  // (m x 3) vertex ids over all surfaces
  Edges edges;          // (k x 2) sorted unique vertex pairs; an edge's id is its row
  std::vector<CollisionSurface> surfaces;
  std::vector<Index> surface_of_vertex;    // (n)
  std::vector<Index> surface_of_triangle;  // (m)
  std::vector<Index> surface_of_edge;      // (k)
  VertexRows rows;
  // (n) surface to which an attachment ties the vertex, -1 for none; empty: no attachments. Faces
  // and edges with such a vertex do not collide with that surface.
  std::vector<Index> attached_surface;
  double contact_stiffness = 1000.0;  // k of a contact [N/m]
};

// Whether triangles of surfaces a and b (possibly the same) must not intersect: at least one is
// cloth, and a cloth against itself has self-collision on.
inline bool kept_apart(const CollisionModel& model, Index a, Index b) {
  const auto cloth = [&](Index s) {
    return model.surfaces[s].kind == CollisionSurface::Kind::Cloth;
  };
  return (cloth(a) || cloth(b)) && (a != b || model.surfaces[a].self_collision);
}

}  // namespace loomstone
