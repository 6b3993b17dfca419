// Spherical harmonics in Schmidt semi-normalisation, which prevents overflow at high degree:
//   Y_lm = sqrt((l-m)! / (l+m)!) P_lm(cos theta) exp(i m phi),   m >= 0,
// where P_lm omits the Condon-Shortley phase (-1)^m. For a sphere of radius a about the origin, let
// Phi be the scalar potential times mu0 / a. For an applied field, Phi is a sum of
// Re(L_lm Y_lm) (r/a)^l. For a charge on the sphere, Phi outside is a sum of
// Re(c_lm Y_lm) (a/r)^(l+1). The coefficients L and c have the unit of mu0 H [T].
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
  // size() is the number of coefficients: the real and the imaginary part of each (l, m) for
  // l = 1 ... degree and m = 0 ... l. slot() is the index of the real part; the imaginary part
  // follows.
  Index size() const { return degree_ * (degree_ + 3); }
  static Index slot(int l, int m) { return (l - 1) * (l + 2) + 2 * m; }

  // Quadrature points on the unit sphere, and the fraction of its area that each point represents.
  // The rule is exact for harmonics up to degree 2 * degree().
  const Points& points() const { return points_; }
  const Vector& shares() const { return shares_; }
  // Transforms between values at points() and the coefficients a of sum Re(a_lm Y_lm).
  Vector coefficients(const Vector& values) const;
  Vector values(const Vector& coefficients) const;

 private:
  // Computes Y_lm at phi = 0 and at the theta of a ring of points. triangle_place() gives its index
  // in `p`.
  void legendre(int ring, std::vector<double>& p) const;

  int degree_, turns_;
  Vector cosines_, weights_;
  Eigen::MatrixXd waves_, sines_;  // cos(m phi) and sin(m phi); rows: azimuths phi, columns: m
  Points points_;
  Vector shares_;
};

// Returns the index of (l, m) in a triangular array with l = 0, 1, ... and m = 0 ... l.
inline std::size_t triangle_place(int l, int m) {
  return static_cast<std::size_t>(l) * (l + 1) / 2 + m;
}

// Factors of the recurrences Y_lm = a z Y_(l-1)m - b Y_(l-2)m and Y_ll = a (x + i y) Y_(l-1)(l-1)
// at points (x, y, z) of the unit sphere, up to degree SphericalHarmonics::most + 2. The factors
// for Y_lm have the index triangle_place(l, m).
struct HarmonicRecurrence {
  std::vector<double> a, b;
};
const HarmonicRecurrence& harmonic_recurrence();

// Multipole-to-local translation along the z axis. add() adds to `target` the coefficients L about
// the centre of one sphere, computed from the coefficients c of another (`source`). Both centres
// lie on the common z axis of their frames.
class CoaxialTranslation {
 public:
  // `height` is z of the source's centre minus z of the target's centre [m]. Radii are in m.
  CoaxialTranslation(double height, int source_degree, double source_radius, int target_degree,
                     double target_radius);
  void add(const Vector& source, Vector& target) const;

 private:
  int source_degree_, target_degree_;
  std::vector<double> factors_;
};

}  // namespace loomstone
