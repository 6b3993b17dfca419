#include "core/magnetics/induction/induced_dipoles.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/base/message.h"
#include "core/magnetics/induction/gmres.h"
#include "core/magnetics/sources/body.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/lane_math.h"
#include "core/parallel/wait_policy.h"

namespace loomstone {

namespace {

// Largest number of spheres for which the factors of distance_kernel() are computed once and kept
// for all iterations. For this number, they take 31 MB.
constexpr Index most_kept = 1400;

// Computes 1/R^3 and 3/R^5 for the distances R of every sphere from the eight spheres at x
// (coordinate arrays). Both factors are 0 if R = 0.
template <class Lanes>
LOOMSTONE_INLINE void distance_kernel(const double* x, const double* positions, Index n,
                                      double* factors) {
  const Lanes3<Lanes> p = lanes3_load<Lanes>(x, n_lanes);
  for (Index j = 0; j < n; ++j, positions += 3, factors += 2 * n_lanes) {
    const Lanes3<Lanes> r{p.x - positions[0], p.y - positions[1], p.z - positions[2]};
    const Lanes square = dot(r, r), inverse = 1.0 / square;
    const Lanes inverse2 = lanes_select(square > 0.0, inverse, Lanes{}),
                inverse3 = inverse2 * lanes_sqrt(inverse2);
    lanes_store(factors, inverse3);
    lanes_store(factors + n_lanes, 3.0 * (inverse3 * inverse2));
  }
}

// Computes the flux density of moments m (n x 3) at eight spheres by (6.5) of [Thomaszewski2010],
// times 4 pi / mu0.
template <class Lanes>
LOOMSTONE_INLINE void moment_kernel(const double* x, const double* positions, const double* factors,
                                    const double* m, Index n, double* field) {
  const Lanes3<Lanes> p = lanes3_load<Lanes>(x, n_lanes);
  Lanes3<Lanes> sum{};
  for (Index j = 0; j < n; ++j, positions += 3, m += 3, factors += 2 * n_lanes) {
    const Lanes3<Lanes> r{p.x - positions[0], p.y - positions[1], p.z - positions[2]};
    const Lanes inverse3 = lanes_load<Lanes>(factors);
    const Lanes along =
        (m[0] * r.x + m[1] * r.y + m[2] * r.z) * lanes_load<Lanes>(factors + n_lanes);
    sum.x += along * r.x - inverse3 * m[0];
    sum.y += along * r.y - inverse3 * m[1];
    sum.z += along * r.z - inverse3 * m[2];
  }
  lanes_store(field, sum.x);
  lanes_store(field + n_lanes, sum.y);
  lanes_store(field + 2 * n_lanes, sum.z);
}

// The operator T, which maps the moments of all spheres to the flux density at each sphere due to
// the others. It is applied to many sets of moments at the same positions.
class MutualField {
 public:
  MutualField(const Team& team, const Points& positions) : team_(team), positions_(positions) {
    const Index n = static_cast<Index>(positions.rows());
    if (n > most_kept) return;
    columns_.resize(3 * n_lanes * eights());
    // The array is not initialised, because every value is written below.
    factors_.reset(new double[static_cast<std::size_t>(2 * n_lanes) * n * eights()]);
    parallel_for(
        team, eights(),
        [&](Index e) {
          double* x = columns_.data() + 3 * n_lanes * e;
          for (int lane = 0; lane < n_lanes; ++lane)
            for (int c = 0; c < 3; ++c)
              x[c * n_lanes + lane] = positions(std::min<Index>(n_lanes * e + lane, n - 1), c);
          LOOMSTONE_WIDEST(distance_kernel)(x, positions.data(), n, factors_of(e));
        },
        grain());
  }

  Points of(const Points& moments) {
    const Index n = static_cast<Index>(positions_.rows());
    if (n > most_kept)
      return magnetic_field(team_, {{std::make_shared<DipoleSet>(positions_, moments), {}}},
                            positions_, "B");
    Points field(n, 3);
    parallel_for(
        team_, eights(),
        [&](Index e) {
          alignas(64) double b[3 * n_lanes];
          LOOMSTONE_WIDEST(moment_kernel)(columns_.data() + 3 * n_lanes * e, positions_.data(),
                                          factors_of(e), moments.data(), n, b);
          for (Index i = n_lanes * e; i < std::min(n, n_lanes * (e + 1)); ++i)
            for (int c = 0; c < 3; ++c)
              field(i, c) = mu0 / (4.0 * pi) * b[c * n_lanes + i - n_lanes * e];
        },
        grain());
    return field;
  }

 private:
  // Number of groups of eight spheres per task. If threads sleep between loops, tasks have 256
  // spheres instead of 64, because it takes time to wake a thread.
  Index grain() const { return threads_sleep() ? 32 : 8; }

  Index eights() const { return (static_cast<Index>(positions_.rows()) + n_lanes - 1) / n_lanes; }
  double* factors_of(Index e) {
    return factors_.get() + static_cast<std::size_t>(2 * n_lanes) * positions_.rows() * e;
  }

  const Team& team_;
  const Points& positions_;
  std::vector<double> columns_;
  std::unique_ptr<double[]> factors_;
};

}  // namespace

double sphere_polarizability(double radius, double susceptibility) {
  // This form of chi / (3 + chi) is also valid for infinite chi.
  const double share = susceptibility > 1.0 ? 1.0 / (3.0 / susceptibility + 1.0)
                                            : susceptibility / (3.0 + susceptibility);
  return 4.0 * pi * radius * radius * radius / mu0 * share;
}

Points induced_moments(const Team& team, const Points& positions, const Vector& polarizabilities,
                       const Points& applied, double tolerance, const Points& start) {
  const Points right = polarizabilities.asDiagonal() * applied;
  const auto rows = [&](const Vector& m) {
    return Eigen::Map<const Points>(m.data(), positions.rows(), 3);
  };
  const auto flat = [](const Points& m) {
    return Vector(Eigen::Map<const Vector>(m.data(), m.size()));
  };
  MutualField mutual(team, positions);
  const auto apply = [&](const Vector& m) {
    return flat(rows(m) - polarizabilities.asDiagonal() * mutual.of(rows(m)));
  };
  const Vector begin = start.rows() == positions.rows() ? flat(start) : Vector();
  const GmresResult solved = gmres(apply, flat(right), tolerance, most_gmres_iterations, begin);
  if (!(solved.residual <= tolerance))
    fail<SolverFailure>(
        "spheres that magnetise each other must reach an equilibrium, got a relative residual of "
        "{:.3g} after {} iterations; separate spheres that overlap",
        solved.residual, solved.iterations);
  return rows(solved.solution);
}

Points sphere_moments(const Team& team, const Points& positions, const std::vector<double>& radii,
                      const std::vector<double>& susceptibilities, const Points& applied,
                      double tolerance) {
  const auto n = static_cast<std::size_t>(positions.rows());
  check_points(positions, "points");
  if (!applied.allFinite()) throw InvalidInput("applied must be finite [T]");
  if (!(tolerance > 0.0 && tolerance < 1.0))
    fail<InvalidInput>("tolerance must be in (0, 1), got {}", tolerance);
  if (radii.size() != n || susceptibilities.size() != n)
    fail<InvalidInput>(
        "each of the {} points must have one radius and one susceptibility, got {} radii and {} "
        "susceptibilities",
        n, radii.size(), susceptibilities.size());
  Vector polarizabilities(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!(radii[i] > 0.0) || !std::isfinite(radii[i]))
      fail<InvalidInput>("radii must be > 0 [m], got {}", radii[i]);
    if (!(susceptibilities[i] >= -1.0))
      fail<InvalidInput>("susceptibilities must be >= -1, got {}", susceptibilities[i]);
    polarizabilities[i] = sphere_polarizability(radii[i], susceptibilities[i]);
  }
  return induced_moments(team, positions, polarizabilities, applied, tolerance);
}

}  // namespace loomstone
