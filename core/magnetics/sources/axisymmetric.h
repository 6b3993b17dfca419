// Axisymmetric sources about the z axis: circular current loops, solenoids (cylindrical current
// sheets), and cylinder and ring magnets.
//
// A body with uniform polarization J has mu0 H = grad(J . grad Psi), where Psi is the Newtonian
// potential of its volume, the integral of 1 / (4 pi distance). A ring is the difference of two
// cylinders. For a cylinder, all second derivatives of Psi follow from three functions of an
// equivalent current sheet on its side: the field components b_z and b_rho, and t = A_phi / rho,
// where A_phi is the vector potential. The third derivatives follow from these functions and from
// current loops at the two ends. Near the axis and far away, azimuthal integrals use the midpoint
// rule, which converges to rounding accuracy there, and differences between the two ends are
// computed without cancellation. Elsewhere, azimuthal integrals are expressed by elliptic
// integrals, as in [Derby2010] for the sheet.
//
// Let Phi be mu0 times the scalar potential. Phi is jointly homogeneous of degree 1 in the size s
// of the body and the position x of the point. By Euler's theorem, Phi = -x.mu0 H + s dPhi/ds. If s
// grows by ds, the body gains a layer of thickness y.n ds/s at each point y of its surface, where n
// is the outward normal. Therefore, s dPhi/ds is the dot product of J and the field of a surface
// charge density y.n. The field of this charge on the end faces follows from the end terms of the
// sheet. That of the charge on the side is expressed by complete elliptic integrals.
//
// At points closer than 1e-12 radii to a surface, the field is the limit from outside. On a rim or
// wire, the field is infinite. Points closer than 1e-12 radii to the side of a cylinder or
// solenoid, or than 1e-15 radii to the wire of a loop, are therefore evaluated at that distance.
#pragma once

#include "core/magnetics/sources/source.h"

namespace loomstone {

class Loop final : public Source {
 public:
  // `turns` coincident circles of the given radius [m] in the plane z = 0. The current per turn [A]
  // flows counter-clockwise as seen from +z.
  Loop(double radius, double current, double turns = 1.0);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  double radius() const override { return radius_; }
  Vec3 moment() const override;
  std::vector<Panel> panels() const override;
  void vector_potential_block(const double* points, Index n, double* potential) const override;
  std::optional<CircularWinding> winding() const override {
    return CircularWinding{radius_, 0.0, ampere_turns_, current_};
  }
  SourcePtr with_current(double current) const override {
    return std::make_shared<Loop>(radius_, current, turns_);
  }
  SourceRecipe recipe() const override;

 private:
  double radius_, current_, turns_, ampere_turns_;
};

class Solenoid final : public Source {
 public:
  // Current sheet on the cylinder |z| <= length / 2 of the given radius [m]. Its total current is
  // `turns` times `current` [A] and flows counter-clockwise as seen from +z.
  Solenoid(double radius, double length, double turns, double current);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  double radius() const override;
  Vec3 moment() const override;
  std::vector<Panel> panels() const override;
  void vector_potential_block(const double* points, Index n, double* potential) const override;
  std::optional<CircularWinding> winding() const override {
    return CircularWinding{radius_, length_, sheet_, current_};
  }
  SourcePtr with_current(double current) const override {
    return std::make_shared<Solenoid>(radius_, length_, turns_, current);
  }
  SourceRecipe recipe() const override;

 private:
  double radius_, length_, turns_, current_, sheet_;
};

class Cylinder final : public Source {
 public:
  // The cylinder |z| <= height / 2, inner_radius <= rho <= radius [m] with polarization J [T].
  Cylinder(double radius, double height, const Vec3& polarization, double inner_radius = 0.0);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  void potential_block(const double* points, Index n, double* potential) const override;
  double radius() const override;
  Vec3 moment() const override;
  std::vector<Panel> panels() const override { return faces(false); }
  std::vector<Panel> surface() const override { return faces(true); }
  std::optional<std::pair<Vec3, Vec3>> box() const override;
  double depth(const Vec3& point) const override;
  std::optional<UniformCylinder> uniform_cylinder() const override {
    return UniformCylinder{radius_, inner_};
  }
  SourceRecipe recipe() const override;
  double outer_radius() const { return radius_; }
  double inner_radius() const { return inner_; }
  double height() const { return height_; }
  const Vec3& polarization() const { return polarization_; }

 private:
  std::vector<Panel> faces(bool all) const;  // all faces, or only those with charge

  double radius_, inner_, height_;
  Vec3 polarization_;
};

}  // namespace loomstone
