// Magnetically linear bodies (soft iron, para- and diamagnets, superconductors) in their own axes,
// and the surface charge that an applied field induces on them. Spheres use a series of solid
// harmonics; the response to each harmonic is exact. Cuboids, cylinders and meshes use boundary
// elements.
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
  // Returns the points at which the applied field is needed, in the axes of the body (n x 3) [m].
  virtual const Points& samples() const = 0;
  // Returns the excitation of the body by an applied field, given as B at samples() (n x 3) [T].
  // The excitation consists of the fluxes through panels [T m^2], or of the coefficients of a
  // sphere's harmonics [T]. It is linear in `field`.
  virtual Vector received(const Points& field) const = 0;
  // Returns the charge that the excitation `received` induces, a vector of the same size: mu0 sigma
  // of each panel times PanelGrid::share, or the coefficients of a sphere's harmonics [T]. The
  // charge is linear in `received`.
  virtual Vector response(const Vector& received) const = 0;
  virtual SourcePtr source(const Vector& charges) const = 0;
  // Like source(charges), but the charge also varies within panels, as the applied field does.
  // Bodies without panels ignore `applied`.
  virtual SourcePtr source(const Vector& charges, const AppliedField& applied) const;
  // Returns the volume mean [T] of the applied field whose excitation is `received`.
  virtual Vec3 mean_field(const Vector& received) const = 0;
  virtual double volume() const = 0;  // [m^3]
  virtual double radius() const = 0;  // radius of the bounding sphere about the origin [m]
  // Returns a hard magnet of 1 T along z with the shape of the body, for geometric queries.
  virtual SourcePtr solid() const = 0;
  // Returns the panels that carry the charge, or null for spheres.
  virtual std::shared_ptr<const PanelSet> panels() const { return nullptr; }
  // Returns the degree of a sphere's solid harmonics, 0 if it is chosen automatically, or -1 for
  // other shapes.
  virtual int sphere_degree() const { return -1; }
  virtual double susceptibility() const = 0;
  virtual SourceRecipe recipe() const = 0;
  virtual std::shared_ptr<const SoftShape> with_susceptibility(double susceptibility) const = 0;
};

using SoftShapePtr = std::shared_ptr<const SoftShape>;

struct SoftBody {
  SoftShapePtr shape;
  RigidPose pose;
  double saturation = 0.0;  // mu0 M_s [T]; 0 for no saturation
};

// Checks the argument `cells` of soft_cuboid() or soft_cylinder(). `shape` is "cuboid" or
// "cylinder". Throws InvalidInput unless `cells` is a multiple of 4 from 8 to 48 (cuboid) or from 8
// to 24 (cylinder). `name` is the name of this argument in the message.
void check_cells(int cells, const std::string& shape, const std::string& name = "cells");

// Throws InvalidInput unless the susceptibility is at least -1 [1] and not 0. Infinity stands for
// ideal iron.
void check_susceptibility(double susceptibility);

// Returns a sphere of the given radius [m]. `degree` is the degree of the solid harmonics. If it is
// 0, induce() chooses the degree from the distances to other bodies. Throws InvalidInput if an
// argument is out of range.
SoftShapePtr soft_sphere(double radius, double susceptibility, int degree);

// Returns a cuboid with edge lengths `size` [m]. Richardson extrapolation combines its responses on
// three grids of panels. The finest grid has `cells` panels along the shortest edge (see
// check_cells()) and at least as many along the others (see cuboid_panels()). If focus > 0 [m],
// there are only two grids, and all edges have `cells` panels on the finer one. These two grids are
// refined near the middle of the wide faces, for a magnet there whose half width is `focus`. Throws
// InvalidInput if an argument is out of range or the finest grid has more than 24,000 panels.
SoftShapePtr soft_cuboid(const Team& team, const Vec3& size, double susceptibility, int cells,
                         double focus = 0.0);

// Returns a cylinder |z| <= height / 2, or a ring if inner_radius > 0 [m]. Richardson extrapolation
// combines its responses on three grids of panels. The finest grid has `cells` rows of panels along
// the height, or more if the cylinder is slender; see cylinder_panels(). Throws Unsupported if the
// height or the wall is less than a fiftieth of the radius, and InvalidInput if an argument is out
// of range or the finest grid has more than 8,000 panels.
SoftShapePtr soft_cylinder(const Team& team, double radius, double height, double inner_radius,
                           double susceptibility, int cells);

// Shape of a closed mesh, relative to the mesh's centre of volume, and the pose of this centre in
// the axes of the mesh. soft_mesh() bisects triangles until there are at least `panels` of them. It
// throws InvalidInput if an argument is invalid, or if `panels` or the number of triangles of the
// mesh exceeds 8,000.
struct SoftMesh {
  SoftShapePtr shape;
  RigidPose pose;
};
SoftMesh soft_mesh(const Team& team, const TriangleMesh& mesh, double susceptibility, Index panels);
// Returns the shape of a mesh whose centre of volume is assumed to be at the origin.
SoftShapePtr soft_mesh_shape(const Team& team, const TriangleMesh& mesh, double susceptibility,
                             Index panels);

}  // namespace loomstone
