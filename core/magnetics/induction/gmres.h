// Generalised minimal residuals [Saad1986] for operators given as functions, without restarts: the
// systems of bodies that magnetise one another are close to the identity, and each product costs
// far more than the sums over the basis.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct GmresResult {
  Vector solution;
  double residual = 0.0;  // norm of it over that of the right side
  int iterations = 0;
};

// apply(x) gives A x. Stops at `tolerance` times the norm of the right side or after `most`
// iterations. start: where to begin, empty: at zero. A start within 1 + 1e-6 tolerances stays as it
// is: a solution, which rounding may put beyond the one, is not improved.
template <class Apply>
GmresResult gmres(Apply&& apply, const Vector& right, double tolerance, int most,
                  const Vector& start = {}) {
  GmresResult result{Vector::Zero(right.size()), 0.0, 0};
  const double size = right.norm();
  if (size == 0.0) return result;
  Vector first = right;
  if (start.size() > 0) first -= apply(start), result.solution = start;
  const double left = first.norm();
  if (start.size() > 0 && left <= (1.0 + 1e-6) * tolerance * size) {
    result.residual = std::min(left / size, tolerance);
    return result;
  }
  first /= left;
  // Arnoldi vectors, the triangle of their products, and the rotations that made it one.
  std::vector<Vector> basis{first}, columns;
  std::vector<double> cosines, sines, rest{left};
  while (std::abs(rest.back()) > tolerance * size && result.iterations < most) {
    const int k = result.iterations++;
    Vector next = apply(basis[k]);
    Vector column(k + 2);
    for (int i = 0; i <= k; ++i) {
      column[i] = next.dot(basis[i]);
      next -= column[i] * basis[i];
    }
    column[k + 1] = next.norm();
    if (column[k + 1] > 0.0) next /= column[k + 1];
    for (int i = 0; i < k; ++i) {
      const double upper = cosines[i] * column[i] + sines[i] * column[i + 1];
      column[i + 1] = cosines[i] * column[i + 1] - sines[i] * column[i];
      column[i] = upper;
    }
    const double length = std::hypot(column[k], column[k + 1]);
    cosines.push_back(column[k] / length);
    sines.push_back(column[k + 1] / length);
    column[k] = length;
    rest.push_back(-sines[k] * rest[k]);
    rest[k] *= cosines[k];
    columns.push_back(std::move(column));
    basis.push_back(std::move(next));
  }
  const int n = result.iterations;
  std::vector<double> shares(n);
  for (int i = n - 1; i >= 0; --i) {
    double value = rest[i];
    for (int k = i + 1; k < n; ++k) value -= columns[k][i] * shares[k];
    shares[i] = value / columns[i][i];
    result.solution += shares[i] * basis[i];
  }
  result.residual = std::abs(rest.back()) / size;
  return result;
}

}  // namespace loomstone
