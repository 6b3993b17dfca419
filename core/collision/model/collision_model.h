// All surfaces that may collide, concatenated in one vertex array. Cloth comes first, in the row
// order of the linear system, followed by rigid bodies and obstacles. Constant after construction.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"

namespace loomstone {

struct CollisionSurface {
  enum class Kind { Cloth, Body, Script };  // Script: obstacle
  std::string name;
  Kind kind = Kind::Cloth;
  Index first_vertex = 0, n_vertices = 0;
  Index first_triangle = 0, n_triangles = 0;
  double thickness = 1e-3;     // contact distance to itself [m]; pairs of surfaces use the mean
  double friction = 0.3;       // friction coefficient [1]; pairs of surfaces use the geometric mean
  bool self_collision = true;  // cloth only
  int body = -1;               // index of the rigid body (Kind::Body), else -1
  // If true, normals of contacts with faces of this surface are interpolated from vertex normals,
  // and edges of this surface have no contacts. EventContacts does not use this flag.
  bool smooth = false;
};

// The rows of the linear system that determine the motion of each collision vertex.
struct VertexRows {
  // A vertex of cloth has its own row. A vertex of a body has the row of the body's translation;
  // the next row is the body's rotation. A vertex of an obstacle has -1.
  std::vector<Index> row;
  std::vector<std::uint8_t> is_body;
};

// The surface to which a vertex is attached. `distance` is an upper bound of the contact distance
// between this surface and the features that contain the vertex.
struct AttachedTo {
  Index surface = -1;     // -1: the vertex is not attached
  double distance = 0.0;  // [m]; 0: features with the vertex do not collide with the surface

  bool excludes(Index other) const { return surface == other && distance == 0.0; }
};

struct CollisionModel {
  Index n_vertices = 0;
  Triangles triangles;  // (m x 3) vertex ids
  Edges edges;          // (k x 2) sorted unique vertex pairs; the edge id is the row
  // Sorted by their first vertex and first triangle. Every vertex and every triangle belongs to one
  // surface.
  std::vector<CollisionSurface> surfaces;
  VertexRows rows;
  // (n) Empty if there are no attachments.
  std::vector<AttachedTo> attached;
  double contact_stiffness = 1000.0;  // stiffness k in the force law of contacts [N/m]
  // Upper bound of gap_floor() (narrow_phase/continuous.h), the gap that certification keeps [m].
  double gap_floor = 1e-5;

  std::size_t bytes() const { return bytes_of(triangles, edges, rows.row, rows.is_body, attached); }
  Index surface_of_vertex(Index vertex) const {
    return containing(vertex, &CollisionSurface::first_vertex);
  }
  Index surface_of_triangle(Index triangle) const {
    return containing(triangle, &CollisionSurface::first_triangle);
  }
  Index surface_of_edge(Index edge) const { return surface_of_vertex(edges(edge, 0)); }

 private:
  // Returns the index of the last surface whose member `first` is at most `feature`.
  Index containing(Index feature, Index CollisionSurface::* first) const {
    const auto next = std::ranges::upper_bound(surfaces, feature, {}, first);
    return static_cast<Index>(next - surfaces.begin()) - 1;
  }
};

// Returns whether triangles of surfaces a and b must not intersect. This is so if at least one of
// the surfaces is cloth and, if a == b, this cloth has self-collision.
inline bool kept_apart(const CollisionModel& model, Index a, Index b) {
  const auto cloth = [&](Index s) {
    return model.surfaces[s].kind == CollisionSurface::Kind::Cloth;
  };
  return (cloth(a) || cloth(b)) && (a != b || model.surfaces[a].self_collision);
}

}  // namespace loomstone
