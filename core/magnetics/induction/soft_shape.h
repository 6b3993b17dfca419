// Linear bodies (soft iron, para- and diamagnets, superconductors) in their own axes: the surface
// charge that an applied field induces. Spheres respond exactly, by solid harmonics; cuboids,
// cylinders and meshes by boundary elements.
#pragma once

#include <memory>
#include <string>

#include "core/magnetics/sources/body.h"

namespace loomstone {

struct AppliedField;
struct PanelSet;

class SoftShape {
 public:
  virtual ~SoftShape() = default;
  // Points at which the applied field is needed (n x 3) [m].
  virtual const Points& samples() const = 0;
  // Reduces the applied mu0 H at the samples (n x 3) [T] to the vector the body responds to;
  // linear.
  virtual Vector received(const Points& field) const = 0;
  // The induced charge, a vector of the same size; linear in `received`.
  virtual Vector response(const Vector& received) const = 0;
  virtual SourcePtr source(const Vector& charges) const = 0;
  // The source with charge that varies within panels as the applied field does; bodies without
  // panels ignore `applied`.
  virtual SourcePtr source(const Vector& charges, const AppliedField& applied) const;
  // Volume mean of the applied field [T].
  virtual Vec3 mean_field(const Vector& received) const = 0;
  virtual double volume() const = 0;  // [m^3]
  virtual double radius() const = 0;  // of the bounding ball about the origin [m]
  // The body as a hard magnet of 1 T along z, for its geometry.
  virtual SourcePtr solid() const = 0;
  // The panels that carry the charge; null for spheres.
  virtual std::shared_ptr<const PanelSet> panels() const { return nullptr; }
  // Degree of a sphere's solid harmonics, 0 if chosen automatically; -1 for other shapes.
  virtual int sphere_degree() const { return -1; }
  virtual double susceptibility() const = 0;
  virtual SourceRecipe recipe() const = 0;
  virtual std::shared_ptr<const SoftShape> with_susceptibility(double susceptibility) const = 0;
};

using SoftShapePtr = std::shared_ptr<const SoftShape>;

struct SoftBody {
  SoftShapePtr shape;
  RigidPose pose;
  double saturation = 0.0;  // mu0 M_s [T], 0: none
};

// Checks the cells of the finest grid on a shape, "cuboid" or "cylinder": throws InvalidInput
// unless they are a multiple of 4, at least 8, and at most what the shape allows. name: of the
// option.
void check_cells(int cells, const std::string& shape, const std::string& name = "cells");

// Throws InvalidInput unless chi >= -1 [1] and other than 0; infinity is ideal iron.
void check_susceptibility(double susceptibility);

// degree: of the solid harmonics; 0: chosen from the distance of other bodies when magnetised.
SoftShapePtr soft_sphere(double radius, double susceptibility, int degree);
// Degree at which the relative error of the force on a sphere is `tolerance`, if the nearest source
// lies at `distance` from its centre.
int sphere_degree(double radius, double distance, double tolerance);
// The same for two such spheres with centres at `distance`.
int sphere_degree(double radius, double other_radius, double distance, double tolerance);

// cells: panels along each edge of the finest of three grids, whose responses are extrapolated
// (Richardson); see check_cells. focus [m]: half the width of a magnet near the middle of the wide
// faces, where panels are refined; 0: no refinement.
SoftShapePtr soft_cuboid(const Team& team, const Vec3& size, double susceptibility, int cells,
                         double focus = 0.0);

// A cylinder |z| <= height / 2 or, with inner_radius > 0, a ring. cells: panels along its side in
// the finest of three grids, as for cuboids. Throws Unsupported if the height or the wall is less
// than a fiftieth of the radius.
SoftShapePtr soft_cylinder(const Team& team, double radius, double height, double inner_radius,
                           double susceptibility, int cells);

// A closed mesh about its centre of volume, which the pose places; its triangles are bisected until
// there are at least `panels`.
struct SoftMesh {
  SoftShapePtr shape;
  RigidPose pose;
};
SoftMesh soft_mesh(const Team& team, const TriangleMesh& mesh, double susceptibility, Index panels);
// The same of a mesh whose centre of volume is taken to be the origin.
SoftShapePtr soft_mesh_shape(const Team& team, const TriangleMesh& mesh, double susceptibility,
                             Index panels);

}  // namespace loomstone
