#include "core/magnetics/induction.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/magnetics/body.h"
#include "core/magnetics/constants.h"
#include "core/magnetics/gmres.h"

namespace loomstone {

namespace {

constexpr int most_iterations = 200;

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
  const auto rows = [&](const Vector& m) { return Eigen::Map<const Points>(m.data(), positions.rows(), 3); };
  const auto flat = [](const Points& m) { return Vector(Eigen::Map<const Vector>(m.data(), m.size())); };
  const auto apply = [&](const Vector& m) {
    const SourcePtr set = std::make_shared<DipoleSet>(positions, rows(m));
    return flat(rows(m) - polarizabilities.asDiagonal() * magnetic_field(team, {{set, {}}}, positions, "B"));
  };
  const GmresResult solved = gmres(apply, flat(right), tolerance, most_iterations);
  if (!(solved.residual <= tolerance))
    throw SolverFailure("spheres that magnetise each other must come to an equilibrium, got a residual of " +
                        std::to_string(solved.residual) + " after " + std::to_string(solved.iterations) +
                        " iterations; keep them from lying in one another");
  return rows(solved.solution);
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
