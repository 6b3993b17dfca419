// The surfaces that may touch, end to end in one vertex array: cloth first (in the order of the
// cloth rows), then rigid bodies, then obstacles. Constant once built.
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
  double thickness = 1e-3;     // contact distance to itself [m]; a pair of surfaces uses the mean
  double friction = 0.3;       // a pair uses the geometric mean [1]
  bool self_collision = true;  // cloth only
  int body = -1;               // index of the rigid body (Kind::Body)
  bool smooth = false;  // closest points on the triangles' rounded surface drive the contact force
};

// Where a collision vertex's motion comes from: a cloth row, a rigid body, or a script.
struct VertexRows {
  std::vector<Index> row;  // cloth row, or translation row of its body; -1 by script
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
  // (n) surface that a vertex is fixed to by an attachment, -1 for none; empty: none at all. Faces
  // and edges with such a vertex do not collide with that surface.
  std::vector<Index> attached_surface;
  double contact_stiffness = 1000.0;  // k of a pair [N/m]
};

// Are triangles of two surfaces (or of one) held against each other? At least one is cloth; a cloth
// without self-collision is not held against itself.
inline bool kept_apart(const CollisionModel& model, Index a, Index b) {
  const auto cloth = [&](Index s) {
    return model.surfaces[s].kind == CollisionSurface::Kind::Cloth;
  };
  return (cloth(a) || cloth(b)) && (a != b || model.surfaces[a].self_collision);
}

}  // namespace loomstone
