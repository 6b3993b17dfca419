// Gauss-Legendre rules. The nodes are the roots of a Legendre polynomial, found by Newton's method.
// The polynomial is evaluated by its three-term recurrence.
#include "core/magnetics/sources/gauss.h"

#include <array>
#include <cmath>
#include <numbers>

namespace loomstone {

namespace {

GaussRule make_rule(int n) {
  GaussRule rule;
  rule.n = n;
  gauss_points(n, rule.nodes, rule.weights);
  for (int i = 0; i < n; ++i) {
    const double x = rule.nodes[i];
    double p = 1.0, before = 0.0;
    for (int k = 0; k < n; ++k) {
      rule.legendre[k * n + i] = rule.weights[i] * p;
      const double next = ((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0);
      before = p;
      p = next;
    }
  }
  return rule;
}

}  // namespace

void gauss_points(int n, double* nodes, double* weights) {
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 1.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double p = 1.0, before = 0.0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k;
        before = p;
        p = next;
      }
      slope = n * (x * p - before) / (x * x - 1.0);
      const double step = p / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    nodes[i] = x;
    weights[i] = 2.0 / ((1.0 - x * x) * slope * slope);
  }
}

const GaussRule& gauss_rule(int n) {
  static const auto rules = [] {
    std::array<GaussRule, most_gauss_points + 1> all;
    for (int k = 1; k <= most_gauss_points; ++k) all[k] = make_rule(k);
    return all;
  }();
  return rules[n];
}

}  // namespace loomstone
