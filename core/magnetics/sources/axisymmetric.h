// Sources about the z axis: circular current loop, solenoid (a sheet of current), cylinder and ring
// magnets.
//
// A uniformly magnetised body has mu0 H = grad(J . grad Psi) with the potential Psi of its volume.
// For a cylinder all second derivatives of Psi follow from three functions of the current sheet on
// its side: its field b_z, b_rho, and t = A_phi / rho; the third ones from the current loops at its
// ends. Integrals over the azimuth are taken by the midpoint rule where it converges to rounding,
// on the axis and far away, with differences between the ends formed without cancellation, and by
// elliptic integrals near the rims, as [Derby2010] has them for the field of the sheet.
//
// The potential Phi of a magnetised body grows with its size as a length does: Phi = - x.mu0 H +
// dPhi/d(size), and to make the body larger adds a layer to it, of thickness x.n, whose potential
// is J. the field of unit charges on its surface times that: on the ends of a cylinder the end
// terms of the sheet, on its side complete elliptic integrals.
//
// On a surface (closer than 1e-12 radii) the value is the outer one; on a rim or wire, where the
// field is infinite, that 1e-15 radii beside it.
#pragma once

#include "core/magnetics/sources/source.h"

namespace loomstone {

class Loop final : public Source {
 public:
  // Circle in z = 0 about the origin; current [A] counter-clockwise seen from +z.
  Loop(double radius, double current);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  double radius() const override { return radius_; }
  Vec3 moment() const override;
  std::vector<Panel> panels() const override;
  void vector_potential_block(const double* points, Index n, double* potential) const override;
  std::optional<CircularWinding> winding() const override {
    return CircularWinding{radius_, 0.0, current_};
  }

 private:
  double radius_, current_;
};

class Solenoid final : public Source {
 public:
  // Sheet of current on the cylinder |z| <= length / 2: `turns` times `current` [A] in all,
  // counter-clockwise seen from +z.
  Solenoid(double radius, double length, double turns, double current);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  double radius() const override;
  Vec3 moment() const override;
  std::vector<Panel> panels() const override;
  void vector_potential_block(const double* points, Index n, double* potential) const override;
  std::optional<CircularWinding> winding() const override {
    return CircularWinding{radius_, length_, sheet_};
  }

 private:
  double radius_, length_, sheet_;
};

class Cylinder final : public Source {
 public:
  // |z| <= height / 2, inner_radius <= rho <= radius [m]; polarization J [T].
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
  double outer_radius() const { return radius_; }
  double inner_radius() const { return inner_; }
  double height() const { return height_; }
  const Vec3& polarization() const { return polarization_; }

 private:
  std::vector<Panel> faces(bool all) const;  // else those with charge

  double radius_, inner_, height_;
  Vec3 polarization_;
};

}  // namespace loomstone
