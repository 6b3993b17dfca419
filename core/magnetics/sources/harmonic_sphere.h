// Surface charge on a sphere about the origin as a series of solid harmonics
// (spherical_harmonics.h). Up to the degree of the series, this is the exact response of a linear
// sphere with susceptibility chi to any applied field. A coefficient L of degree l of the applied
// potential induces the charge coefficient c = -L l chi / (l chi + 2 l + 1).
#pragma once

#include <vector>

#include "core/magnetics/sources/source.h"
#include "core/magnetics/sources/spherical_harmonics.h"

namespace loomstone {

class HarmonicSphere final : public Source {
 public:
  // The charge of `series` with the given coefficients. Its quadrature points are those of
  // `samples`, whose degree must be at least that of `series`.
  HarmonicSphere(double radius, std::shared_ptr<const SphericalHarmonics> series,
                 std::shared_ptr<const SphericalHarmonics> samples, Vector coefficients);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;  // 0 inside
  double radius() const override { return radius_; }
  Vec3 moment() const override;
  std::optional<std::pair<Vec3, Vec3>> box() const override {
    return std::pair(Vec3(Vec3::Constant(-radius_)), Vec3(Vec3::Constant(radius_)));
  }
  double depth(const Vec3& point) const override { return radius_ - point.norm(); }
  bool spherical() const override { return true; }
  SeriesEnd series_end() const override;
  bool induced() const override { return true; }
  std::vector<PanelSample> charges() const override;
  // Returns the estimated error due to the terms beyond the degree of the series, as charges at the
  // points of charges() [A m]. The estimate uses the terms of the last two degrees.
  Vector charge_errors() const override;

 private:
  Vec3 inside(const Vec3& point, Quantity quantity) const;
  // Returns the charges at the quadrature points [A m] for a charge density with the coefficients
  // `density` [A/m].
  Vector charges_of(const Vector& density) const;

  double radius_;
  std::shared_ptr<const SphericalHarmonics> series_, samples_;
  Vector coefficients_;
  std::vector<double> field_[3], gradient_[6];
};

}  // namespace loomstone
