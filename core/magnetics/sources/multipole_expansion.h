// Multipole expansion of a bounded source in solid harmonics: its field far away, from the moments
// of its magnetic charge. With the irregular harmonics
//   S_lm(r) = (l-m)! P_lm(cos theta) exp(i m phi) / r^(l+1),   P without the sign (-1)^m,
// the potential is sum Re(c_lm S_lm), m >= 0. A derivative of S_lm is a combination of harmonics of
// degree l + 1, so every component of field and gradient is a sum of the same form over the same
// S_lm.
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "core/magnetics/sources/source.h"

namespace loomstone {

class MultipoleExpansion {
 public:
  // Sources use the expansion at distances beyond this many radii.
  static constexpr double near = 4.0;
  static constexpr int degree = 24;  // 4^-25 = 1e-15

  // charges [T m^2] (mu0 times magnetic charge) at positions (n x 3) [m] inside the ball of
  // `radius` [m] about the origin.
  MultipoleExpansion(const Points& positions, const Vector& charges, double radius);

  // The expansion of dipoles; moments times mu0 (n x 3) [T m^3].
  static MultipoleExpansion of_dipoles(const Points& positions, const Points& moments,
                                       double radius);

  // mu0 H [T] or its gradient [T/m] of one block. Relative error: 1e-6 beyond 2 radii, rounding
  // beyond `near` radii; values closer than 2 radii are meaningless.
  void field_block(const double* points, Index n, double* field) const;
  void gradient_block(const double* points, Index n, double* gradient) const;

 private:
  MultipoleExpansion(std::vector<std::complex<double>> moments, double radius);

  double radius_;
  // Coefficients (real, imaginary) of each component for l = 0 ... degree + 2, m = 0 ... l; lengths
  // in units of the radius.
  std::array<std::vector<double>, 3> field_;
  std::array<std::vector<double>, 6> gradient_;
};

}  // namespace loomstone
