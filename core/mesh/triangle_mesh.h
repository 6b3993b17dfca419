// Immutable triangle mesh, validated when it is created.
#pragma once

#include <string>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

using Corners2 = Mat32;  // rest coordinates (weft, warp) of a triangle [m], one corner per row

class TriangleMesh {
 public:
  // vertices (n x 3) [m]; triangles (m x 3); uv (k x 2) rest coordinates [m], or empty;
  // uv_triangles (m x 3) rows of uv, or empty if equal to the triangles. Along a seam between
  // panels, a vertex has several uv. Throws InvalidInput for NaN, infinity, no vertices, no
  // triangles, arrays that do not match, an index out of range, zero area (also in uv), a repeated
  // vertex in a face, duplicate faces, a non-manifold edge (more than two faces), inconsistent
  // orientation, inverted uv and isolated vertices. Accepts panels mirrored in uv as a whole, and
  // triangle fans that share only one vertex.
  TriangleMesh(Points vertices, Triangles triangles, Points2 uv = {}, Triangles uv_triangles = {});

  Index n_vertices() const { return static_cast<Index>(vertices_.rows()); }
  Index n_triangles() const { return static_cast<Index>(triangles_.rows()); }
  const Points& vertices() const { return vertices_; }
  const Triangles& triangles() const { return triangles_; }
  bool has_uv() const { return uv_.rows() > 0; }
  const Points2& uv() const { return uv_; }
  const Triangles& uv_triangles() const { return uv_triangles_; }

  double mean_edge() const;  // mean length of the edges [m]
  bool closed() const;       // every edge has two faces
  bool flat() const;         // all vertices lie in one plane, within 1e-9 times the mesh's size
  // Rotates and scales the vertices about the origin, then translates them. Keeps the uv.
  TriangleMesh moved(const Vec3& translation,
                     const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity(),
                     double scale = 1.0) const;
  // Vertex i of the result is vertex vertex_order[i] of this mesh, and triangle t is triangle
  // triangle_order[t]. The rows of uv keep their order.
  TriangleMesh reordered(const std::vector<Index>& vertex_order,
                         const std::vector<Index>& triangle_order) const;

 private:
  Points vertices_;
  Triangles triangles_;
  Points2 uv_;
  Triangles uv_triangles_;
};

// Merges vertices with exactly equal positions. Each triangle keeps its uv. The function is meant
// for files that repeat vertices along texture seams, because repeated vertices would cut the
// surface into pieces.
TriangleMesh welded(const TriangleMesh& mesh);

// Rest coordinates of the corners of each triangle of a mesh. In a triangle that is mirrored in uv,
// the sign of u is reversed before the uv are used, so all areas are positive. With uv and
// rest_from_uv, the uv are the rest coordinates. With uv but without rest_from_uv, each triangle
// keeps its shape in space; weft is the direction in which u increases at constant v. Without uv,
// the mesh must be flat; weft is then the projection of the x axis on its plane or, if this
// projection nearly vanishes, that of the y axis.
class RestCorners {
 public:
  // The mesh must outlive this object. Throws InvalidInput for a curved mesh without uv; `where`
  // names the mesh in the message.
  RestCorners(const TriangleMesh& mesh, bool rest_from_uv, const std::string& where);
  Corners2 operator[](Index triangle) const;

 private:
  const TriangleMesh* mesh_;
  bool rest_from_uv_;
  Vec3 weft_ = Vec3::Zero();  // weft direction; set only for meshes without uv
};

// Returns the rest coordinates of all triangles, as RestCorners gives them.
std::vector<Corners2> rest_corners(const TriangleMesh& mesh, bool rest_from_uv,
                                   const std::string& where);

}  // namespace loomstone
