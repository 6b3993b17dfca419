// Charge on a sphere about the origin as a series of solid harmonics: the exact response of a
// linear sphere to any field. In Schmidt's normalisation, which neither grows nor vanishes at high
// degree,
//   Y_lm = sqrt((l-m)! / (l+m)!) P_lm(cos theta) exp(i m phi),  P without the sign (-1)^m, m >= 0,
// a field applied from outside has the potential a sum Re(L_lm Y_lm) (r/a)^l, the charge outside a
// sum Re(c_lm Y_lm) (a/r)^(l+1), with coefficients in T (mu0 H). A linear sphere answers with c = -
// l chi / (l chi + 2 l + 1) L.
#pragma once

#include <complex>
#include <vector>

#include "core/magnetics/sources/source.h"

namespace loomstone {

class SphereSeries {
 public:
  static constexpr int most = 400;  // degree

  explicit SphereSeries(int degree);
  int degree() const { return degree_; }
  // Coefficients as real, imaginary part of (l, m), l = 1 ... degree, m = 0 ... l.
  Index size() const { return degree_ * (degree_ + 3); }
  static Index slot(int l, int m) { return (l - 1) * (l + 2) + 2 * m; }

  // Points on the unit sphere for sums exact up to twice the degree, and their share of the whole
  // sphere.
  const Points& points() const { return points_; }
  const Vector& shares() const { return shares_; }
  // sum Re(a_lm Y_lm) through values at the points.
  Vector coefficients(const Vector& values) const;
  Vector values(const Vector& coefficients) const;

 private:
  void legendre(int ring,
                std::vector<double>& p) const;  // P_lm of (l, m) at (l - 1)(l + 2) / 2 + m

  int degree_, turns_;
  Vector cosines_, weights_;
  Eigen::MatrixXd waves_, sines_;  // cos and sin of m times the azimuths (turns x degree + 1)
  Points points_;
  Vector shares_;
};

class HarmonicSphere final : public Source {
 public:
  HarmonicSphere(double radius, std::shared_ptr<const SphereSeries> series, Vector coefficients);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;  // inside: 0
  double radius() const override { return radius_; }
  Vec3 moment() const override;
  std::optional<std::pair<Vec3, Vec3>> box() const override {
    return std::pair(Vec3(Vec3::Constant(-radius_)), Vec3(Vec3::Constant(radius_)));
  }
  double depth(const Vec3& point) const override { return radius_ - point.norm(); }
  bool spherical() const override { return true; }
  bool induced() const override { return true; }
  std::vector<PanelSample> charges() const override;

 private:
  Vec3 inside(const Vec3& point, Quantity quantity) const;

  double radius_;
  std::shared_ptr<const SphereSeries> series_;
  Vector coefficients_;
  std::vector<double> field_[3], gradient_[6];
};

// Coefficients L about a centre of the charge c of another sphere, centres on a common z axis of
// both frames.
class CoaxialTranslation {
 public:
  // height: of the source above the target [m]; degrees of both, radii [m].
  CoaxialTranslation(double height, int source_degree, double source_radius, int target_degree,
                     double target_radius);
  void add(const Vector& source, Vector& target) const;

 private:
  int source_degree_, target_degree_;
  std::vector<double> factors_;
};

}  // namespace loomstone
