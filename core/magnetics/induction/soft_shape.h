// Linear bodies (soft iron, para- and diamagnets, superconductors) in their own axes: what charge
// their surface takes on in an applied field. Spheres answer exactly, by solid harmonics; cuboids,
// cylinders and meshes by panels.
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
  // Points where the field that others apply is wanted (n x 3) [m].
  virtual const Points& samples() const = 0;
  // What of the applied mu0 H (n x 3) [T] at the samples the body answers to: a vector, linear in
  // it.
  virtual Vector received(const Points& field) const = 0;
  // The charge it answers with, a vector of the same size, linear in what is received.
  virtual Vector response(const Vector& received) const = 0;
  virtual SourcePtr source(const Vector& charges) const = 0;
  // The same of panels, whose charge in the field of others varies within them as that does.
  virtual SourcePtr source(const Vector& charges, const AppliedField& applied) const;
  // Of the applied field, over the volume [T].
  virtual Vec3 mean_field(const Vector& received) const = 0;
  virtual double volume() const = 0;  // [m^3]
  virtual double radius() const = 0;  // of the ball about the origin that holds the body [m]
  // The same body as a hard magnet of 1 T along z, for questions about its form.
  virtual SourcePtr solid() const = 0;
  virtual std::shared_ptr<const PanelSet> panels() const {
    return nullptr;
  }  // that carry the charge, if it is panels
  // Of spheres: the degree of their solid harmonics that was given, 0: automatic; -1: no sphere.
  virtual int sphere_degree() const { return -1; }
  virtual double susceptibility() const = 0;
  virtual std::shared_ptr<const SoftShape> with_susceptibility(double susceptibility) const = 0;
};

using SoftShapePtr = std::shared_ptr<const SoftShape>;

struct SoftBody {
  SoftShapePtr shape;
  RigidPose pose;
  double saturation = 0.0;  // mu0 M_s [T], 0: none
};

// Cells of the finest grid on a shape, "cuboid" or "cylinder"; throws InvalidInput unless a
// multiple of 4 from 8 on that the shape takes.
void check_cells(int cells, const std::string& shape, const std::string& name = "cells");

// Throws InvalidInput unless chi >= -1 [1] and other than 0; infinity is ideal iron.
void check_susceptibility(double susceptibility);

// degree: of the solid harmonics; 0: chosen when the body is induced, from what is near.
SoftShapePtr soft_sphere(double radius, double susceptibility, int degree);
// The degree with which the force on a sphere errs by `tolerance` where sources begin `distance`
// from its centre.
int sphere_degree(double radius, double distance, double tolerance);
// Two such spheres with their centres `distance` apart.
int sphere_degree(double radius, double other_radius, double distance, double tolerance);

// cells: panels along each edge, >= 8 and even. The errors of three grids, of which this is the
// finest, go with the second and third power of the size of panels; their answers are extrapolated
// together. focus [m]: half the width of what is near the middle of wide faces, where panels are
// finer then; 0: none.
SoftShapePtr soft_cuboid(const Team& team, const Vec3& size, double susceptibility, int cells,
                         double focus = 0.0);

// A cylinder |z| <= height / 2 or, with inner_radius > 0, a ring. cells: panels along its side, >=
// 8 and a multiple of 4; three grids are extrapolated, as for cuboids. Throws Unsupported where
// height or wall is less than a fiftieth of the radius.
SoftShapePtr soft_cylinder(const Team& team, double radius, double height, double inner_radius,
                           double susceptibility, int cells);

// A closed mesh about its own centre of volume (the pose tells where it is), its triangles halved
// until there are at least `panels`.
struct SoftMesh {
  SoftShapePtr shape;
  RigidPose pose;
};
SoftMesh soft_mesh(const Team& team, const TriangleMesh& mesh, double susceptibility, Index panels);

}  // namespace loomstone
