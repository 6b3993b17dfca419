// Real fields on spheres by solid harmonics, in Schmidt's normalisation, which neither grows nor
// vanishes at high degree:
//   Y_lm = sqrt((l-m)! / (l+m)!) P_lm(cos theta) exp(i m phi),  P without the sign (-1)^m, m >= 0.
// A field applied from outside has the potential a sum Re(L_lm Y_lm) (r/a)^l, the charge on a
// sphere of radius a outside of it a sum Re(c_lm Y_lm) (a/r)^(l+1), with coefficients in T (mu0 H).
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

class SphericalHarmonics {
 public:
  static constexpr int most = 400;  // degree

  explicit SphericalHarmonics(int degree);
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

// Place of (l, m) in a triangle of coefficients, l = 0, 1 ..., m = 0 ... l.
inline std::size_t triangle_place(int l, int m) {
  return static_cast<std::size_t>(l) * (l + 1) / 2 + m;
}

// Factors of the recurrence Y_lm = a z Y_(l-1)m - b Y_(l-2)m, Y_ll = a (x + i y) Y_(l-1)(l-1), up
// to degree SphericalHarmonics::most + 2.
struct HarmonicRecurrence {
  std::vector<double> a, b;
};
const HarmonicRecurrence& harmonic_recurrence();

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
