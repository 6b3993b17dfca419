#include "core/integration/stable_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace loomstone {

namespace {

// Start vector of the power iteration. It varies from vertex to vertex, as do the eigenvectors of
// the largest eigenvalues.
Points rough_vector(Index n) {
  Points u(n, 3);
  for (Index i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c) u(i, c) = std::sin(12.9898 * (3 * i + c) + 78.233);
  return u;
}

// Largest eigenvalue of M^-1 A by power iteration, where apply(u) returns A u.
template <class Apply>
double largest_eigenvalue(const ClothModel& model, Apply&& apply) {
  // The number of iterations is our choice. The result can be slightly below the eigenvalue, and
  // the stable step is then slightly too long. Automatic steps are only half as long as the stable
  // step.
  constexpr int iterations = 60;
  Points u = rough_vector(model.n_vertices);
  double eigenvalue = 0.0;
  for (int i = 0; i < iterations; ++i) {
    u /= u.norm();
    Points next = apply(u);
    for (Index row = 0; row < model.n_vertices; ++row) next.row(row) /= model.mass[row];
    eigenvalue = next.norm();
    if (!(eigenvalue > 0.0)) return 0.0;
    u = next;
  }
  return eigenvalue;
}

}  // namespace

double stable_step(Elasticity& elasticity, const ClothModel& model, const Points& x) {
  if (model.n_vertices == 0) return std::numeric_limits<double>::infinity();
  const Index n = model.n_vertices;
  const auto forces = [&](const Points& at, const Points& v) {
    Points force = Points::Zero(n, 3);
    elasticity.add_implicit_forces({}, at, &v, 0, n, force);
    elasticity.add_explicit_bending({}, at, v, 0, n, force);
    return force;
  };
  const Points still = Points::Zero(n, 3);
  // Forces are differentiated with respect to position by central differences along unit vectors,
  // with displacements of this length [m] to either side.
  const double length = 1e-6 * (x.colwise().maxCoeff() - x.colwise().minCoeff()).norm();
  const double k = largest_eigenvalue(model, [&](const Points& u) -> Points {
    return (forces(x - length * u, still) - forces(x + length * u, still)) / (2.0 * length);
  });
  const double d = largest_eigenvalue(
      model, [&](const Points& u) -> Points { return 0.5 * (forces(x, -u) - forces(x, u)); });
  if (k == 0.0) return d > 0.0 ? 2.0 / d : std::numeric_limits<double>::infinity();
  return (std::sqrt(d * d + 4.0 * k) - d) / k;
}

double stiffening_of_rank(Elasticity& elasticity, const Team& team, const Points& x) {
  Points green;
  Vector stretch;
  elasticity.strain_of_rank(team, x, green, stretch);
  double largest = 1.0;
  for (Index t = 0; t < green.rows(); ++t) {
    const double mean = 0.5 * (green(t, 0) + green(t, 1)), half = 0.5 * (green(t, 0) - green(t, 1)),
                 radius = std::sqrt(half * half + green(t, 2) * green(t, 2));
    largest = std::max(largest, 1.0 + 3.0 * (mean + radius) + std::max(0.0, mean - radius));
  }
  return largest;
}

}  // namespace loomstone
