// Uniformly magnetised polyhedra as surface charge J.n on their faces: any closed triangle mesh,
// and the cuboid, whose faces meet at right angles and need fewer terms.
//
// A face of charge sigma adds sigma/4pi [n Omega + sum over its edges m L]: Omega the solid angle
// under which it is seen (positive on the side of its normal n), m the normal of an edge in the
// plane of the face, outwards, L = log((r1
// + r2 + l) / (r1 + r2 - l)) of an edge of length l with distances r1, r2 to its ends [Wilton1984].
// Edges of neighbouring faces are summed first, so an edge where the charge does not change costs
// nothing. The face's potential is sigma/4pi [sum of (m.s) L - (n.r) Omega], r from a corner to the
// point, s from the point to an end of the edge.
//
// On a face (closer than 1e-12 of the size) the value is the outer one. On an edge the field is
// infinite; it is evaluated 1e-15 of the size beside it. Farther than 4 radii multipoles take over,
// which lose no digits however far the point.
#pragma once

#include <mutex>
#include <optional>

#include "core/magnetics/sources/multipole_expansion.h"
#include "core/mesh/spatial_query.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

class Polyhedron : public Source {
 public:
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  void potential_block(const double* points, Index n, double* potential) const override;
  double radius() const override { return radius_; }
  Vec3 moment() const override;

  std::vector<Panel> panels() const override { return faces(false); }
  std::vector<Panel> surface() const override { return faces(true); }
  std::optional<std::pair<Vec3, Vec3>> box() const override;
  double depth(const Vec3& point) const override;

  // The surface, wound counter-clockwise seen from outside, and its charge.
  const Points& vertices() const { return vertices_; }        // (n x 3) [m]
  const Triangles& triangles() const { return triangles_; }   // (m x 3)
  const Vec3& polarization() const { return polarization_; }  // J [T]
  double volume() const { return volume_; }                   // [m^3]
  // Of its charge, made when first asked for.
  const MultipoleExpansion& multipoles() const;

 protected:
  Polyhedron(Points vertices, Triangles triangles, const Vec3& polarization);
  virtual std::vector<Panel> faces(bool all) const;  // else those with charge
  virtual void near_field(const double* points, Index n, Quantity quantity, double* field) const;

 private:
  Points vertices_;
  Triangles triangles_;
  Vec3 polarization_;
  double radius_ = 0.0, volume_ = 0.0;
  // Tables of the kernels.
  std::vector<double> faces_;  // (m x 16) three corners, unit normal, twice the area, charge / 4
                               // pi, 2 unused [m, m^2, T]
  std::vector<double> edges_;  // (k x 14) two ends, length, sum of charge/4pi times m, the same
                               // times n with the edge's sense
  mutable std::once_flag once_;
  mutable std::optional<MultipoleExpansion> far_;
  mutable std::once_flag query_once_;
  mutable std::optional<SpatialQuery> query_;
};

class MeshMagnet final : public Polyhedron {
 public:
  // polarization J [T] in the axes of the mesh. Throws InvalidInput where the mesh is open or
  // encloses no volume.
  MeshMagnet(const TriangleMesh& mesh, const Vec3& polarization);
};

class Cuboid final : public Polyhedron {
 public:
  // size: the three edges [m], centre at the origin; polarization J [T].
  Cuboid(const Vec3& size, const Vec3& polarization);
  double depth(const Vec3& point) const override;
  std::optional<UniformCuboid> uniform_cuboid() const override {
    return UniformCuboid{size_, polarization()};
  }

 protected:
  std::vector<Panel> faces(bool all) const override;
  void near_field(const double* points, Index n, Quantity quantity, double* field) const override;

 private:
  Vec3 size_;
};

}  // namespace loomstone
