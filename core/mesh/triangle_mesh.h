// Immutable triangle mesh, validated once.
#pragma once

#include <string>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

using Corners2 = Mat32;  // rest coordinates of a triangle: row = corner, columns weft and warp [m]

class TriangleMesh {
 public:
  // vertices (n x 3) [m]; triangles (m x 3); uv (k x 2) rest coordinates [m] or empty; uv_triangles
  // (m x 3) indices into uv, or empty: the triangles themselves. Panels meet along a seam by
  // different uv at the same vertex. Throws InvalidInput naming the item: NaN, empty, index out of
  // range, zero area (also in uv), repeated vertex in a face, duplicate faces, non-manifold edge
  // (more than two faces), inconsistent orientation, inverted uv, isolated vertex. A panel mirrored
  // in uv as a whole and fans that meet in one vertex only are accepted.
  TriangleMesh(Points vertices, Triangles triangles, Points2 uv = {}, Triangles uv_triangles = {});

  Index n_vertices() const { return static_cast<Index>(vertices_.rows()); }
  Index n_triangles() const { return static_cast<Index>(triangles_.rows()); }
  const Points& vertices() const { return vertices_; }
  const Triangles& triangles() const { return triangles_; }
  bool has_uv() const { return uv_.rows() > 0; }
  const Points2& uv() const { return uv_; }
  const Triangles& uv_triangles() const { return uv_triangles_; }

  double mean_edge() const;  // [m]
  bool closed() const;       // every edge has two faces
  bool flat() const;         // all vertices in one plane (1e-9 of the size)
  TriangleMesh moved(const Vec3& translation,
                     const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity(),
                     double scale = 1.0) const;  // uv unchanged
  TriangleMesh reordered(const std::vector<Index>& vertex_order,
                         const std::vector<Index>& triangle_order) const;

 private:
  Points vertices_;
  Triangles triangles_;
  Points2 uv_;
  Triangles uv_triangles_;
};

// Vertices at exactly the same position become one; each triangle keeps its uv. For files that
// repeat vertices along texture seams, which tear a surface into pieces.
TriangleMesh welded(const TriangleMesh& mesh);

// Material coordinates of every triangle's corners. With uv: the uv themselves when `rest_from_uv`,
// else the flattened 3D triangle turned so that uv gives the weft direction. Without uv: a flat
// mesh uses its own plane (weft = the world axis x projected, or y where that vanishes), a curved
// one throws InvalidInput. Every triangle comes out with positive area: a panel mirrored in uv is
// turned over about its warp axis. Weft is the direction in which u grows at constant v.
std::vector<Corners2> rest_corners(const TriangleMesh& mesh, bool rest_from_uv,
                                   const std::string& where);

}  // namespace loomstone
