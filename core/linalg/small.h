// Closed forms for 2x2 and 3x3 matrices: inverses, eigenvalues, positive parts and rotations.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/types.h"

namespace loomstone {

// Inverts a symmetric positive definite matrix. If a leading minor is not positive, returns false
// and leaves `inverse` unchanged.
inline bool invert_positive_definite(const Mat3& a, Mat3& inverse) {
  const double c00 = a(1, 1) * a(2, 2) - a(1, 2) * a(1, 2);
  const double c01 = a(0, 2) * a(1, 2) - a(0, 1) * a(2, 2);
  const double c02 = a(0, 1) * a(1, 2) - a(0, 2) * a(1, 1);
  const double minor2 = a(0, 0) * a(1, 1) - a(0, 1) * a(0, 1);
  const double determinant = a(0, 0) * c00 + a(0, 1) * c01 + a(0, 2) * c02;
  if (!(a(0, 0) > 0.0) || !(minor2 > 0.0) || !(determinant > 0.0)) return false;
  const double c11 = a(0, 0) * a(2, 2) - a(0, 2) * a(0, 2);
  const double c12 = a(0, 1) * a(0, 2) - a(0, 0) * a(1, 2);
  inverse << c00, c01, c02, c01, c11, c12, c02, c12, minor2;
  inverse *= 1.0 / determinant;
  return true;
}

// Returns the eigenvalues of a symmetric 2x2 matrix, the larger one first.
inline Vec2 symmetric_eigenvalues(const Mat2& a) {
  const double mean = 0.5 * (a(0, 0) + a(1, 1));
  const double radius = std::hypot(0.5 * (a(0, 0) - a(1, 1)), a(0, 1));
  return {mean + radius, mean - radius};
}

// Returns the symmetric matrix A = `a` with its negative eigenvalues replaced by zero. If the
// eigenvalues are l > 0 and m < 0, the projector on the eigenvector of l is (A - m I) / (l - m).
inline Mat2 positive_part(const Mat2& a) {
  const Vec2 eigenvalues = symmetric_eigenvalues(a);
  if (eigenvalues[1] >= 0.0) return a;
  if (eigenvalues[0] <= 0.0) return Mat2::Zero();
  return eigenvalues[0] / (eigenvalues[0] - eigenvalues[1]) *
         (a - eigenvalues[1] * Mat2::Identity());
}

// The eigenvalue that is farthest from the other two eigenvalues of a symmetric 3x3 matrix A, and a
// unit eigenvector. The eigenvalue is computed as in Smith, "Eigenvalues of a symmetric 3x3
// matrix", Comm. ACM 4 (1961). The eigenvector has the direction of the longest cross product of
// two rows of A - value I.
struct EigenPair {
  double value = 0.0;
  Vec3 vector = Vec3::UnitX();
};
inline EigenPair separate_eigenpair(const Mat3& a) {
  const double mean = a.trace() / 3.0;
  const Mat3 deviator = a - mean * Mat3::Identity();
  const double size = std::sqrt(deviator.squaredNorm() / 6.0);
  if (!(size > 0.0)) return {mean, Vec3::UnitX()};
  const double half_determinant = std::clamp(0.5 * (deviator / size).determinant(), -1.0, 1.0);
  // The angle satisfies cos(3 angle) = |half_determinant|. The eigenvalue farthest from the others
  // is the largest one if half_determinant >= 0, and the smallest one otherwise.
  const double angle = std::acos(std::abs(half_determinant)) / 3.0;
  const double value = mean + std::copysign(2.0 * size * std::cos(angle), half_determinant);
  const Mat3 shifted = a - value * Mat3::Identity();
  Vec3 longest = shifted.row(0).cross(shifted.row(1)).transpose();
  for (const Vec3& other : {Vec3(shifted.row(0).cross(shifted.row(2)).transpose()),
                            Vec3(shifted.row(1).cross(shifted.row(2)).transpose())})
    if (other.squaredNorm() > longest.squaredNorm()) longest = other;
  const double length = longest.norm();
  if (!(length > 0.0)) return {value, Vec3::UnitX()};
  return {value, longest / length};
}

// Returns the symmetric 3x3 matrix `a` with its negative eigenvalues replaced by zero. Treats the
// eigenpair of separate_eigenpair() first, and then a 2x2 problem in the plane perpendicular to its
// eigenvector.
inline Mat3 positive_part(const Mat3& a) {
  const EigenPair apart = separate_eigenpair(a);
  const Vec3 u = apart.vector.unitOrthogonal(), w = apart.vector.cross(u);
  Mat32 across;
  across << u, w;
  const Mat2 rest = across.transpose() * a * across;
  Mat2 symmetric;
  symmetric << rest(0, 0), rest(0, 1), rest(0, 1), rest(1, 1);
  return std::max(apart.value, 0.0) * apart.vector * apart.vector.transpose() +
         across * positive_part(symmetric) * across.transpose();
}

// Returns the rotation R of the polar decomposition F = R U of a 2x2 matrix with positive
// determinant.
inline Mat2 polar_rotation(const Mat2& f) {
  const double c = f(0, 0) + f(1, 1), s = f(1, 0) - f(0, 1), length = std::hypot(c, s);
  Mat2 rotation;
  rotation << c / length, -s / length, s / length, c / length;
  return rotation;
}

}  // namespace loomstone
