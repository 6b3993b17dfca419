// Gauss-Legendre quadrature on [-1, 1].
#pragma once

namespace loomstone {

inline constexpr int most_gauss_points = 24;

struct GaussRule {
  int n = 0;
  double nodes[most_gauss_points], weights[most_gauss_points];
  double legendre[most_gauss_points *
                  most_gauss_points];  // (n x n) P_degree(node) times the weight of the node
};

// The rule with n points, 1 <= n <= most_gauss_points; exact for polynomials up to degree 2 n - 1.
const GaussRule& gauss_rule(int n);

// Nodes and weights of a rule with any number of points n >= 1, written to arrays of length n.
void gauss_points(int n, double* nodes, double* weights);

}  // namespace loomstone
