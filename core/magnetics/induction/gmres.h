// GMRES, the generalised minimal residual method [Saad1986], for operators given as functions. It
// does not restart, because a product with the operator costs far more than orthogonalisation.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

inline constexpr int most_gmres_iterations = 200;

struct GmresResult {
  Vector solution;
  double residual = 0.0;  // norm of the residual, relative to that of the right-hand side [1]
  int iterations = 0;
};

// Solves A x = `right`; apply(x) returns A x. The solve ends if the norm of the residual is at most
// `tolerance` times that of `right`, or after `most` iterations. `start` is the initial guess (warm
// start); if it is empty, the guess is zero. `start` is returned unchanged if its relative residual
// is at most (1 + 1e-6) times the tolerance, because rounding may lift the residual of a converged
// solution slightly above the tolerance. In this case, GmresResult::residual is at most the
// tolerance. If `right` is zero, the solution is zero for any `start`.
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
  // Arnoldi vectors, and the columns of the Hessenberg matrix, which Givens rotations make
  // triangular.
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
