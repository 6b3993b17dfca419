// Spherical harmonics in Schmidt's semi-normalisation, which neither overflows nor underflows at
// high degree:
//   Y_lm = sqrt((l-m)! / (l+m)!) P_lm(cos theta) exp(i m phi),  P without the sign (-1)^m, m >= 0.
// About a sphere of radius a, the potential of a field applied from outside is
// a sum Re(L_lm Y_lm) (r/a)^l, and the potential outside of charge on the sphere is
// a sum Re(c_lm Y_lm) (a/r)^(l+1), with coefficients L and c in T (mu0 H).
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

class SphericalHarmonics {
 public:
  static constexpr int most = 400;  // highest degree

  explicit SphericalHarmonics(int degree);
  int degree() const { return degree_; }
  // Coefficients: real and imaginary part of each (l, m), l = 1 ... degree, m = 0 ... l.
  Index size() const { return degree_ * (degree_ + 3); }
  static Index slot(int l, int m) { return (l - 1) * (l + 2) + 2 * m; }

  // Quadrature points on the unit sphere, exact up to twice the degree, and their shares of its
  // area.
  const Points& points() const { return points_; }
  const Vector& shares() const { return shares_; }
  // Transforms between values at the points and the coefficients a of sum Re(a_lm Y_lm).
  Vector coefficients(const Vector& values) const;
  Vector values(const Vector& coefficients) const;

 private:
  void legendre(int ring,
                std::vector<double>& p) const;  // P_lm by triangle_place(l, m)

  int degree_, turns_;
  Vector cosines_, weights_;
  Eigen::MatrixXd waves_, sines_;  // cos and sin of m times the azimuths (turns x degree + 1)
  Points points_;
  Vector shares_;
};

// Index of (l, m) in a triangular array, l = 0, 1 ..., m = 0 ... l.
inline std::size_t triangle_place(int l, int m) {
  return static_cast<std::size_t>(l) * (l + 1) / 2 + m;
}

// Factors of the recurrences Y_lm = a z Y_(l-1)m - b Y_(l-2)m and Y_ll = a (x + i y) Y_(l-1)(l-1),
// up to degree SphericalHarmonics::most + 2.
struct HarmonicRecurrence {
  std::vector<double> a, b;
};
const HarmonicRecurrence& harmonic_recurrence();

// Multipole-to-local translation along the z axis: coefficients L about one sphere's centre from
// the charge c of another, with both centres on the common z axis of both frames.
class CoaxialTranslation {
 public:
  // height: z of the source's centre less that of the target [m]; radii [m].
  CoaxialTranslation(double height, int source_degree, double source_radius, int target_degree,
                     double target_radius);
  void add(const Vector& source, Vector& target) const;

 private:
  int source_degree_, target_degree_;
  std::vector<double> factors_;
};

}  // namespace loomstone
