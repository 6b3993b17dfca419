// Triangle buffers for OpenGL. Every vertex has a position, a shading normal, uv coordinates and
// two values that determine colours. A vertex is split where uv or normals differ between its
// triangles: along uv seams and along sharp edges of bodies.
#pragma once

#include <vector>

#include "core/base/frame.h"
#include "renderer/gl_objects.h"

namespace loomstone {

// Vertices and triangles to draw. Each drawn vertex refers to a vertex of the frame and to a normal
// group. The vertices of a group share one shading normal.
struct DrawnMesh {
  std::vector<Index> vertex;        // (k) vertex of the frame
  std::vector<Index> normal_group;  // (k) in [0, n_groups)
  Index n_groups = 0;
  Triangles triangles;               // (m x 3) indices of drawn vertices, sorted by part
  std::vector<Eigen::Vector2f> uv;   // (k) [m]; zeros for bodies without a texture
  std::vector<Index> first_of_part;  // (parts + 1) first row of each part in `triangles`, then m
};

// Returns the mesh of the cloths, with one part for each cloth. A vertex is split where its
// triangles differ in uv, but its copies share one normal.
DrawnMesh drawn_cloth(const FrameTopology& topology);
// Returns the mesh of the bodies and obstacles, with one part for each. The parts of floors are
// empty. A vertex is split where its triangles differ in uv, and at sharp edges. An edge is sharp
// if the normals of its two triangles differ by more than `crease_degrees` when the vertices are at
// `body_vertices` [m].
DrawnMesh drawn_bodies(const FrameTopology& topology, const Points& body_vertices,
                       double crease_degrees = 40.0);

// Returns (k x 3) unit normals of the drawn vertices. The normal of a group is the mean of the
// normals of the triangles at its vertices, weighted by the triangles' angles there and scaled to
// unit length. It is the z axis if this mean is zero.
Points shading_normals(const DrawnMesh& mesh, const Points& positions);

// OpenGL buffers of a drawn mesh.
class MeshBuffers {
 public:
  MeshBuffers(const GL& gl, const DrawnMesh& mesh, bool with_edges);
  // `values` and `others` are the two values that determine colours: one number per vertex of the
  // frame. If one of them is empty, its numbers are 0.
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
  std::vector<float> floats_;  // scratch of update()
};

// A square whose uv coordinates run over [-1, 1] along both sides.
class SquareBuffers {
 public:
  explicit SquareBuffers(const GL& gl);
  void update(const Vec3& centre, const Vec3& side_a, const Vec3& side_b, const Vec3& normal);
  void draw() const;

 private:
  const GL* gl_;
  GlObject vertex_array_, vertices_;
};

// Affine function that gives the uv at the point (a, b) of a square, with a and b from -1 to 1:
// centre + a * side_a + b * side_b.
struct SquareUv {
  Eigen::Vector2f centre = Eigen::Vector2f::Zero(), side_a = centre, side_b = centre;  // [m]
};

// The square that shows a floor.
struct PlacedFloor {
  Index body;  // index of the floor among bodies and obstacles
  const SquareBuffers* square;
  SquareUv uv;  // zeros for floors without a texture
};

}  // namespace loomstone
