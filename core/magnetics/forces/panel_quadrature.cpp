#include "core/magnetics/forces/panel_quadrature.h"

#include <algorithm>
#include <cmath>

#include "core/base/simd.h"
#include "core/magnetics/forces/overlap.h"
#include "core/magnetics/sources/gauss.h"

namespace loomstone {

namespace {

// Integrand of the force and torque, or of the energy, in the axes of the source `by`.
struct Integrand : PanelTask {
  Mat3 rotation;

  // Evaluates the integrand, as a density with respect to u and v, at the nu x nv points of a
  // tensor-product rule. The rule covers the part of the panel between `from` and `from` + `size`,
  // which are pairs (u, v).
  void evaluate(const Panel& panel, const double* from, const double* size, int nu, int nv,
                Vec6* values) const {
    const GaussRule &ru = gauss_rule(nu), &rv = gauss_rule(nv);
    const Index n = nu * nv, padded = (n + n_lanes - 1) / n_lanes * n_lanes;
    alignas(64) double x[3 * points_per_block], h[3 * points_per_block];
    PanelSample samples[points_per_block];
    const bool energy = quantity == PanelQuantity::energy;
    Index i = 0;
    for (int iu = 0; iu < nu; ++iu) {
      const double u = from[0] + size[0] * 0.5 * (1.0 + ru.nodes[iu]);
      for (int iv = 0; iv < nv; ++iv, ++i) {
        samples[i] = panel.at(u, from[1] + size[1] * 0.5 * (1.0 + rv.nodes[iv]));
        Vec3 point = pose.position + rotation * samples[i].position;
        if (!energy && samples[i].charge != 0.0) point = moved_outside(by, point);
        for (int c = 0; c < 3; ++c) x[c * padded + i] = point[c];
      }
    }
    for (; i < padded; ++i)
      for (int c = 0; c < 3; ++c) x[c * padded + i] = x[c * padded + n - 1];
    by.field_block(x, padded, energy ? Quantity::flux_density : Quantity::mu0_field_strength, h);
    for (i = 0; i < n; ++i) {
      const Vec3 field(h[i], h[padded + i], h[2 * padded + i]);
      if (energy) {
        values[i].setZero();
        values[i][0] =
            -panel.magnetization.dot(samples[i].position) * (rotation * samples[i].area).dot(field);
        continue;
      }
      const Vec3 force = samples[i].charge * field + (rotation * samples[i].current).cross(field);
      values[i].head<3>() = force;
      values[i].tail<3>() = (rotation * samples[i].position).cross(force) / radius;
    }
  }
};

// Part of a panel (a rectangle in u and v), with the integral over it and the estimated quadrature
// error in each direction.
struct Leaf {
  Index panel;
  double from[2], size[2];
  Vec6 value;
  double error[2];
};

// Returns the estimated error of a Gauss rule in one direction (see panel_quadrature.h). Each entry
// of `sums` belongs to one of the rule's points in this direction and is the integral over the
// other direction.
double rule_error(const Vec6* sums, const GaussRule& rule) {
  double largest = 0.0, last = 0.0;
  for (int degree = 0; degree < rule.n; ++degree) {
    const double* legendre = rule.legendre + degree * rule.n;
    Vec6 coefficient = legendre[0] * sums[0];
    for (int i = 1; i < rule.n; ++i) coefficient += legendre[i] * sums[i];
    const double size = (degree + 0.5) * coefficient.norm();
    largest = std::max(largest, size);
    if (degree >= rule.n - 2) last = std::max(last, size);
  }
  return largest > 0.0 ? 2.0 * last * last / largest : 0.0;
}

void integrate(const Integrand& integrand, int n, Leaf& leaf) {
  const Panel& panel = integrand.panels[leaf.panel];
  const int nu = n, nv = panel.line() ? 1 : n;
  const GaussRule &ru = gauss_rule(nu), &rv = gauss_rule(nv);
  Vec6 values[points_per_block], along_u[most_gauss_points], along_v[most_gauss_points];
  integrand.evaluate(panel, leaf.from, leaf.size, nu, nv, values);
  const double share = 0.25 * leaf.size[0] * leaf.size[1];  // weights add up to 2 in each direction
  leaf.value.setZero();
  for (int i = 0; i < nu; ++i) along_u[i].setZero();
  for (int k = 0; k < nv; ++k) along_v[k].setZero();
  for (int i = 0; i < nu; ++i) {
    for (int k = 0; k < nv; ++k) {
      along_u[i] += share * rv.weights[k] * values[i * nv + k];
      along_v[k] += share * ru.weights[i] * values[i * nv + k];
    }
    leaf.value += ru.weights[i] * along_u[i];
  }
  leaf.error[0] = rule_error(along_u, ru);
  leaf.error[1] = nv > 1 ? rule_error(along_v, rv) : 0.0;
}

struct Total {
  Vec6 value = Vec6::Zero();
  double error = 0.0, absolute = 0.0;
};

Total total_of(const std::vector<Leaf>& leaves) {
  Total t;
  for (const Leaf& leaf : leaves) {
    t.value += leaf.value;
    t.error += leaf.error[0] + leaf.error[1];
    t.absolute += leaf.value.norm();
  }
  return t;
}

// Integrates over all panels. Bisects leaves whose error exceeds half of an equal share of the
// tolerated error, until the total error meets the tolerance or most_evaluations is exceeded.
Total adapt(const Integrand& integrand, double tolerance, double least) {
  // `n` is the number of points in each direction. Larger numbers are faster at small tolerances.
  const int n = tolerance >= 1e-3 ? 5 : tolerance >= 1e-6 ? 7 : 10;
  std::vector<Leaf> leaves(integrand.panels.size());
  Index evaluations = 0;
  for (Index p = 0; p < static_cast<Index>(leaves.size()); ++p) {
    leaves[p] = Leaf{p, {0.0, 0.0}, {1.0, 1.0}, Vec6::Zero(), {0.0, 0.0}};
    integrate(integrand, n, leaves[p]);
    evaluations += n * n;
  }
  for (;;) {
    const Total total = total_of(leaves);
    const double size = std::max(total.value.head<3>().norm(), total.value.tail<3>().norm());
    // If the integrals over the leaves nearly cancel, the tolerance is relative to 1e-6 of the sum
    // of the norms of these integrals.
    const double goal = tolerance * std::max({size, least, 1e-6 * total.absolute});
    if (total.error <= goal || evaluations > most_evaluations) return total;
    const double share = 0.5 * goal / static_cast<double>(leaves.size());
    const std::size_t count = leaves.size();
    for (std::size_t i = 0; i < count; ++i) {
      if (leaves[i].error[0] + leaves[i].error[1] <= share) continue;
      const int axis = leaves[i].error[0] >= leaves[i].error[1] ? 0 : 1;
      leaves[i].size[axis] *= 0.5;
      Leaf other = leaves[i];
      other.from[axis] += other.size[axis];
      integrate(integrand, n, leaves[i]);
      integrate(integrand, n, other);
      leaves.push_back(other);
      evaluations += 2 * n * n;
    }
  }
}

}  // namespace

PanelIntegral integrate_panels(const PanelTask& task, double tolerance, double least) {
  const Total total = adapt({task, rotation_matrix(task.pose.orientation)}, tolerance, least);
  return {total.value, total.error};
}

}  // namespace loomstone
