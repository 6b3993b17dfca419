// Uniformly magnetised sphere about the origin. Outside, its field is exactly that of a dipole.
// Inside, B = 2/3 J and mu0 H = -J/3.
#pragma once

#include "core/magnetics/sources/dipoles.h"

namespace loomstone {

class Sphere final : public Source {
 public:
  Sphere(double radius, const Vec3& polarization);  // radius [m], polarization J [T]
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  void potential_block(const double* points, Index n, double* potential) const override;
  double radius() const override { return radius_; }
  Vec3 moment() const override { return dipole_.moment(); }
  const DipoleSet* dipoles() const override { return &dipole_; }
  std::optional<std::pair<Vec3, Vec3>> box() const override {
    return std::pair(Vec3(Vec3::Constant(-radius_)), Vec3(Vec3::Constant(radius_)));
  }
  double depth(const Vec3& point) const override { return radius_ - point.norm(); }
  bool spherical() const override { return true; }
  SourceRecipe recipe() const override {
    return {"sphere", {{"radius", radius_}, {"polarization", polarization_}}, {}, {}};
  }
  const Vec3& polarization() const { return polarization_; }

 private:
  double radius_;
  Vec3 polarization_;
  DipoleSet dipole_;
};

}  // namespace loomstone
