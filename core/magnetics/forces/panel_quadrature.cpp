#include "core/magnetics/forces/panel_quadrature.h"

#include <algorithm>
#include <cmath>

#include "core/base/simd.h"
#include "core/magnetics/forces/cut_panels.h"
#include "core/magnetics/forces/overlap.h"
#include "core/magnetics/sources/gauss.h"

namespace loomstone {

namespace {

// Number of parts of a panel above which the panel is cut where the field is singular, if these
// places are known.
constexpr Index most_uncut_parts = 16;

// Part of a panel (a rectangle in u and v), with the integral over it and the estimated quadrature
// error in each direction.
struct Leaf {
  Index panel;
  double from[2], size[2];
  Vec6 value;
  double error[2];
};

// Integrand of the force and torque, or of the energy, in the axes of the source `by`.
struct Integrand : PanelTask {
  Mat3 rotation;

  // Returns the sample at (g(u), g(v)), where g(w) = w^2 (3 - 2 w) makes functions that are
  // singular at the edges of the panel smooth. Area, charge and current are densities with respect
  // to u, v.
  static PanelSample graded(const Panel& panel, double u, double v) {
    PanelSample sample = panel.at(u * u * (3.0 - 2.0 * u), v * v * (3.0 - 2.0 * v));
    const double density = 36.0 * u * (1.0 - u) * v * (1.0 - v);
    sample.area *= density, sample.charge *= density, sample.current *= density;
    return sample;
  }

  // Cuts a panel where the field of `by` can be singular: along the planes of the faces of a
  // cuboid, or, if the panel is a disc, along the projected rims of a cylinder. Returns no pieces
  // for other combinations of panel and `by`, or if cut_along_rims() returns none.
  std::vector<Panel> cut(const Panel& panel) const {
    const bool flat =
        panel.shape == Panel::Shape::parallelogram || panel.shape == Panel::Shape::triangle;
    if (const auto cuboid = by.uniform_cuboid(); cuboid && flat)
      return cut_along_faces(panel, pose, *cuboid);
    if (const auto cuboid = by.uniform_cuboid(); cuboid && panel.shape == Panel::Shape::disc)
      return cut_disc_along_faces(panel, pose, *cuboid);
    if (const auto cylinder = by.uniform_cylinder(); cylinder && panel.shape == Panel::Shape::disc)
      return cut_along_rims(panel, pose, *cylinder);
    return {};
  }

  // Evaluates the integrand, as a density with respect to u and v, at the nu x nv points of a
  // tensor-product rule on the leaf. If `cut`, u and v are those of graded().
  void evaluate(const Panel& panel, bool cut, const Leaf& leaf, int nu, int nv,
                Vec6* values) const {
    const GaussRule &ru = gauss_rule(nu), &rv = gauss_rule(nv);
    const Index n = nu * nv, padded = (n + n_lanes - 1) / n_lanes * n_lanes;
    alignas(64) double x[3 * points_per_block], h[3 * points_per_block];
    PanelSample samples[points_per_block];
    const bool energy = quantity == PanelQuantity::energy;
    Index i = 0;
    for (int iu = 0; iu < nu; ++iu) {
      const double u = leaf.from[0] + leaf.size[0] * 0.5 * (1.0 + ru.nodes[iu]);
      for (int iv = 0; iv < nv; ++iv, ++i) {
        const double v = leaf.from[1] + leaf.size[1] * 0.5 * (1.0 + rv.nodes[iv]);
        samples[i] = cut ? graded(panel, u, v) : panel.at(u, v);
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

void integrate(const Integrand& integrand, const Panel& panel, bool cut, int n, Leaf& leaf) {
  const int nu = n, nv = panel.line() ? 1 : n;
  const GaussRule &ru = gauss_rule(nu), &rv = gauss_rule(nv);
  Vec6 values[points_per_block], along_u[most_gauss_points], along_v[most_gauss_points];
  integrand.evaluate(panel, cut, leaf, nu, nv, values);
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

// The panels of an integral and their parts.
struct Subdivision {
  const Integrand& integrand;
  // Number of points of the rules in each direction. Larger numbers are faster at small tolerances.
  int n;
  std::vector<Panel> panels;  // first those of the integrand, then pieces of them
  Index n_uncut = static_cast<Index>(panels.size());
  std::vector<Leaf> leaves = {};
  std::vector<Index> n_parts = {};  // leaves of each panel; -1: the panel must not be cut (again)
  Index evaluations = 0;

  void integrate_leaf(Leaf& leaf) {
    integrate(integrand, panels[leaf.panel], leaf.panel >= n_uncut, n, leaf);
    evaluations += n * n;
  }

  void add_leaf(Index panel) {
    leaves.push_back(Leaf{panel, {0.0, 0.0}, {1.0, 1.0}, Vec6::Zero(), {0.0, 0.0}});
    integrate_leaf(leaves.back());
  }

  void bisect(std::size_t i) {
    const int axis = leaves[i].error[0] >= leaves[i].error[1] ? 0 : 1;
    leaves[i].size[axis] *= 0.5;
    Leaf other = leaves[i];
    other.from[axis] += other.size[axis];
    integrate_leaf(leaves[i]);
    integrate_leaf(other);
    leaves.push_back(other);
    if (n_parts[other.panel] >= 0) ++n_parts[other.panel];
  }

  // Replaces a panel by pieces along whose edges the field is singular, if the places where it is
  // singular are known. Parts of these pieces resolve the field with far fewer points.
  void cut(Index panel) {
    const std::vector<Panel> pieces = integrand.cut(panels[panel]);
    n_parts[panel] = -1;
    if (pieces.empty()) return;
    std::erase_if(leaves, [&](const Leaf& leaf) { return leaf.panel == panel; });
    for (const Panel& piece : pieces) {
      panels.push_back(piece);
      n_parts.push_back(-1);
      add_leaf(static_cast<Index>(panels.size()) - 1);
    }
  }
};

// Integrates over all panels. Bisects leaves whose error exceeds half of an equal share of the
// tolerated error, until the total error meets the tolerance or most_evaluations is exceeded. Cuts
// panels with more than most_uncut_parts leaves.
Total adapt(const Integrand& integrand, double tolerance, double least) {
  Subdivision all{integrand, tolerance >= 1e-3 ? 5 : tolerance >= 1e-6 ? 7 : 10, integrand.panels};
  for (std::size_t p = 0; p < integrand.panels.size(); ++p) {
    all.n_parts.push_back(1);
    all.add_leaf(static_cast<Index>(p));
  }
  for (;;) {
    const Total total = total_of(all.leaves);
    const double size = std::max(total.value.head<3>().norm(), total.value.tail<3>().norm());
    // If the integrals over the leaves nearly cancel, the tolerance is relative to 1e-6 of the sum
    // of the norms of these integrals.
    const double goal = tolerance * std::max({size, least, 1e-6 * total.absolute});
    if (total.error <= goal || all.evaluations > most_evaluations) return total;
    const double share = 0.5 * goal / static_cast<double>(all.leaves.size());
    const std::size_t count = all.leaves.size();
    for (std::size_t i = 0; i < count; ++i)
      if (all.leaves[i].error[0] + all.leaves[i].error[1] > share) all.bisect(i);
    for (std::size_t p = 0; p < integrand.panels.size(); ++p)
      if (all.n_parts[p] > most_uncut_parts) all.cut(static_cast<Index>(p));
  }
}

}  // namespace

PanelIntegral integrate_panels(const PanelTask& task, double tolerance, double least) {
  const Total total = adapt({task, rotation_matrix(task.pose.orientation)}, tolerance, least);
  return {total.value, total.error};
}

}  // namespace loomstone
