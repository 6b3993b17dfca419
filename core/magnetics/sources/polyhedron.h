// Uniformly magnetised polyhedra, modelled by the surface charge J.n on their faces. They are
// closed triangle meshes or cuboids. The field of a cuboid needs fewer terms than that of a mesh.
//
// A face with charge density sigma [T] contributes sigma/4pi [n Omega + sum over its edges of m L]
// to mu0 H at a point. Omega is the solid angle of the face seen from the point, positive if the
// point is on the side to which the normal n of the face points. m is the outward normal of an edge
// in the plane of the face. An edge of length l whose ends are at distances r1, r2 from the point
// has L = log((r1 + r2 + l) / (r1 + r2 - l)) [Wilton1984]. The contributions of the two faces at an
// edge are added in advance, so edges between coplanar faces drop out. The potential of a face,
// multiplied by mu0, is sigma/4pi [sum over its edges of (m.s) L - (n.r) Omega]. Here r points from
// a corner of the face to the point, and s from the point to an end of the edge.
//
// At points closer than 1e-12 radii (of the body, see radius()) to a face, the field is the limit
// from outside. The field is infinite on an edge, so points closer than 1e-15 radii to an edge are
// evaluated at that distance. At 4 radii or more from the origin, field and gradient are computed
// by a multipole expansion, because their closed forms lose digits with distance.
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

  // Seen from outside, the corners of every triangle are in counter-clockwise order.
  const Points& vertices() const { return vertices_; }        // (n x 3) [m]
  const Triangles& triangles() const { return triangles_; }   // (m x 3)
  const Vec3& polarization() const { return polarization_; }  // J [T]
  double volume() const { return volume_; }                   // [m^3]
  // Returns the multipole expansion of the surface charge. The first call computes it.
  const MultipoleExpansion& multipoles() const;

 protected:
  Polyhedron(Points vertices, Triangles triangles, const Vec3& polarization);
  virtual std::vector<Panel> faces(bool all) const;  // all faces, or only those with charge
  virtual void near_field(const double* points, Index n, Quantity quantity, double* field) const;

 private:
  Points vertices_;
  Triangles triangles_;
  Vec3 polarization_;
  double radius_ = 0.0, volume_ = 0.0;
  // (m x 16) Kernel data of each face: three corners [m], unit normal, twice the area [m^2], and
  // sigma / 4 pi [T]. The last two columns are unused.
  std::vector<double> faces_;
  // (k x 14) Kernel data of each edge that does not drop out: two ends, length, and two sums over
  // the faces at the edge, in the symbols at the top of this file. The first is the sum of
  // sigma/4pi m. The second is the sum of sigma/4pi n, in which a face counts as negative if its
  // order of corners leads from the edge's second end to the first. The last column is unused.
  std::vector<double> edges_;
  mutable std::once_flag once_;
  mutable std::optional<MultipoleExpansion> far_;
  mutable std::once_flag query_once_;
  mutable std::optional<SpatialQuery> query_;
};

class MeshMagnet final : public Polyhedron {
 public:
  // The polarization J [T] is given in the axes of the mesh. Throws InvalidInput if J is not finite
  // or if the mesh is open, is inside out or encloses a volume below 1e-12 radius()^3.
  MeshMagnet(const TriangleMesh& mesh, const Vec3& polarization);
  SourceRecipe recipe() const override {
    return {"mesh",
            {{"polarization", polarization()}},
            std::make_shared<const TriangleMesh>(vertices(), triangles()),
            {}};
  }
};

class Cuboid final : public Polyhedron {
 public:
  // A cuboid with edge lengths `size` [m], centred at the origin, with polarization J [T].
  Cuboid(const Vec3& size, const Vec3& polarization);
  double depth(const Vec3& point) const override;
  std::optional<UniformCuboid> uniform_cuboid() const override {
    return UniformCuboid{size_, polarization()};
  }
  SourceRecipe recipe() const override {
    return {"cuboid", {{"size", size_}, {"polarization", polarization()}}, {}, {}};
  }

 protected:
  std::vector<Panel> faces(bool all) const override;
  void near_field(const double* points, Index n, Quantity quantity, double* field) const override;

 private:
  Vec3 size_;
};

}  // namespace loomstone
