// Closed forms for 2x2 and 3x3 matrices.
#pragma once

#include <cmath>

#include "core/base/types.h"

namespace loomstone {

// Inverse of a symmetric positive definite matrix; false (and `inverse` untouched) where it is not, by its leading minors.
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

}  // namespace loomstone
