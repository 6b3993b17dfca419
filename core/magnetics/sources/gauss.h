// Gauss-Legendre quadrature on [-1, 1].
#pragma once

namespace loomstone {

inline constexpr int most_gauss_points = 24;

struct GaussRule {
  int n = 0;
  double nodes[most_gauss_points], weights[most_gauss_points];
  // (n x n) Legendre polynomial of each degree (row) at each node, times the weight of the node.
  double legendre[most_gauss_points * most_gauss_points];
};

// Returns the rule with n points, 1 <= n <= most_gauss_points. It is exact for polynomials up to
// degree 2 n - 1.
const GaussRule& gauss_rule(int n);

// Computes the nodes and weights of the rule with n >= 1 points; n may exceed most_gauss_points.
// Both arrays have length n.
void gauss_points(int n, double* nodes, double* weights);

}  // namespace loomstone
