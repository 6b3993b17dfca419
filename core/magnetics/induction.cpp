#include "core/magnetics/induction.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/magnetics/body.h"
#include "core/magnetics/constants.h"

namespace loomstone {

namespace {

constexpr int most_iterations = 200;

double product(const Team& team, const Points& a, const Points& b) {
  return parallel_sum(team, static_cast<Index>(a.rows()), [&](Index i) { return a.row(i).dot(b.row(i)); });
}

}  // namespace

double sphere_polarizability(double radius, double susceptibility) {
  // chi / (3 + chi) without infinity over infinity.
  const double share =
      susceptibility > 1.0 ? 1.0 / (3.0 / susceptibility + 1.0) : susceptibility / (3.0 + susceptibility);
  return 4.0 * pi * radius * radius * radius / mu0 * share;
}

Points induced_moments(const Team& team, const Points& positions, const Vector& polarizabilities, const Points& applied,
                       double tolerance) {
  const Points right = polarizabilities.asDiagonal() * applied;
  const double size = std::sqrt(product(team, right, right));
  if (size == 0.0) return right;
  const auto apply = [&](const Points& m) {
    const SourcePtr set = std::make_shared<DipoleSet>(positions, m);
    return Points(m - polarizabilities.asDiagonal() * magnetic_field(team, {{set, {}}}, positions, "B"));
  };
  // Arnoldi vectors, the triangle of their products, and the rotations that made it one.
  std::vector<Points> basis{right / size};
  std::vector<Vector> columns;
  std::vector<double> cosines, sines, rest{size};
  while (std::abs(rest.back()) > tolerance * size) {
    const int k = static_cast<int>(columns.size());
    if (k == most_iterations)
      throw SolverFailure("spheres that magnetise each other must come to an equilibrium, got a residual of " +
                          std::to_string(std::abs(rest.back()) / size) + " after " + std::to_string(k) +
                          " iterations; keep them from lying in one another");
    Points next = apply(basis[k]);
    Vector column(k + 2);
    for (int i = 0; i <= k; ++i) {
      column[i] = product(team, next, basis[i]);
      next -= column[i] * basis[i];
    }
    column[k + 1] = std::sqrt(product(team, next, next));
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
  const int n = static_cast<int>(columns.size());
  Points moments = Points::Zero(positions.rows(), 3);
  std::vector<double> shares(n);
  for (int i = n - 1; i >= 0; --i) {
    double value = rest[i];
    for (int k = i + 1; k < n; ++k) value -= columns[k][i] * shares[k];
    shares[i] = value / columns[i][i];
    moments += shares[i] * basis[i];
  }
  return moments;
}

Points sphere_moments(const Team& team, const Points& positions, const std::vector<double>& radii,
                      const std::vector<double>& susceptibilities, const Points& applied, double tolerance) {
  const auto n = static_cast<std::size_t>(positions.rows());
  check_points(positions, "points");
  if (!applied.allFinite()) throw InvalidInput("applied must be finite [T]");
  if (!(tolerance > 0.0 && tolerance < 1.0))
    throw InvalidInput("tolerance must be in (0, 1), got " + std::to_string(tolerance));
  if (radii.size() != n || susceptibilities.size() != n)
    throw InvalidInput("radii and susceptibilities must be one for each of the " + std::to_string(n) + " points, got " +
                       std::to_string(radii.size()) + " and " + std::to_string(susceptibilities.size()));
  Vector polarizabilities(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!(radii[i] > 0.0) || !std::isfinite(radii[i]))
      throw InvalidInput("radii must be > 0 [m], got " + std::to_string(radii[i]));
    if (!(susceptibilities[i] >= -1.0))
      throw InvalidInput("susceptibilities must be >= -1, got " + std::to_string(susceptibilities[i]));
    polarizabilities[i] = sphere_polarizability(radii[i], susceptibilities[i]);
  }
  return induced_moments(team, positions, polarizabilities, applied, tolerance);
}

}  // namespace loomstone
