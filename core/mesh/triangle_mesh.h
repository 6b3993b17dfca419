// Immutable triangle mesh, validated when it is made.
#pragma once

#include <string>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

using Corners2 = Mat32;  // rest coordinates of a triangle: row = corner, columns weft and warp [m]

class TriangleMesh {
 public:
  // vertices (n x 3) [m]; triangles (m x 3); uv (k x 2) rest coordinates [m] or empty; uv_triangles
  // (m x 3) rows of uv, or empty: equal to the triangles. Along a seam between panels a vertex has
  // several uv. Throws InvalidInput naming the item: NaN, empty, index out of range, zero area
  // (also in uv), repeated vertex in a face, duplicate faces, non-manifold edge (more than two
  // faces), inconsistent orientation, inverted uv, isolated vertex. Accepts panels mirrored in uv
  // as a whole and fans that meet in one vertex only.
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

// Merges vertices with exactly equal positions; each triangle keeps its uv. For files that repeat
// vertices along texture seams, which would cut the surface into pieces.
TriangleMesh welded(const TriangleMesh& mesh);

// Rest coordinates of the corners of every triangle. With uv and rest_from_uv: the uv. With uv
// alone: the triangle in space, flattened and rotated so that weft is the direction in which u
// grows at constant v. Without uv: the plane of a flat mesh (weft = the world axis x projected on
// it, or y if that vanishes); a curved mesh throws InvalidInput. Areas are positive: a panel
// mirrored in uv is turned over about its warp axis.
std::vector<Corners2> rest_corners(const TriangleMesh& mesh, bool rest_from_uv,
                                   const std::string& where);

}  // namespace loomstone
