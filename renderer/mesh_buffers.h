// Triangles as the graphics card wants them: every vertex with position, shading normal, cloth
// coordinates and two values. Vertices are split where those differ between triangles: cloth along
// seams of uv, bodies along sharp edges.
#pragma once

#include <vector>

#include "core/base/frame.h"
#include "renderer/gl_objects.h"

namespace loomstone {

// Which vertices are drawn. A drawn vertex knows its vertex in the frame and the group whose
// triangles make its normal.
struct DrawnMesh {
  std::vector<Index> vertex;        // (k) of the frame, per drawn vertex
  std::vector<Index> normal_group;  // (k)
  Index n_groups = 0;
  Triangles triangles;               // (m x 3) drawn vertices; sorted by part
  std::vector<Eigen::Vector2f> uv;   // (k) [m]
  std::vector<Index> first_of_part;  // (parts + 1) rows of `triangles`
};

// Parts are the cloths. Split by uv, smooth across seams.
DrawnMesh drawn_cloth(const FrameTopology& topology);
// Parts are the bodies; floors are left out. Split where neighbouring triangles of `body_vertices`
// meet at more than `crease_degrees`.
DrawnMesh drawn_bodies(const FrameTopology& topology, const Points& body_vertices,
                       double crease_degrees = 40.0);

// (k x 3) unit normals of the drawn vertices: mean of their group's triangles, weighted by the
// angle at the corner.
Points shading_normals(const DrawnMesh& mesh, const Points& positions);

// A drawn mesh in buffers.
class MeshBuffers {
 public:
  MeshBuffers(const GL& gl, const DrawnMesh& mesh, bool with_edges);
  // values, others: (number of frame vertices) or empty.
  void update(const Points& positions, const Vector& values, const Vector& others);
  Index n_parts() const { return static_cast<Index>(mesh_.first_of_part.size()) - 1; }
  void draw() const;
  void draw_part(Index part) const;
  void draw_edges() const;

 private:
  const GL* gl_;
  DrawnMesh mesh_;
  GlObject vertex_array_, vertices_, indices_, edges_;
  GLsizei n_edge_indices_ = 0;
  std::vector<float> floats_;  // scratch of update
};

// A square about `centre`; its uv run over [-1, 1] along both sides.
class SquareBuffers {
 public:
  explicit SquareBuffers(const GL& gl);
  void update(const Vec3& centre, const Vec3& side_a, const Vec3& side_b, const Vec3& normal);
  void draw() const;

 private:
  const GL* gl_;
  GlObject vertex_array_, vertices_;
};

}  // namespace loomstone
