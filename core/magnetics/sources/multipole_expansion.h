// Far field of a bounded source as a multipole expansion of its magnetic charge in solid harmonics.
// The irregular harmonics are
//   S_lm(r) = (l-m)! P_lm(cos theta) exp(i m phi) / r^(l+1),   m >= 0,
// where P_lm omits the Condon-Shortley phase (-1)^m. The potential is the sum of Re(c_lm S_lm). A
// derivative of S_lm is a combination of harmonics of degree l + 1. Every component of field and
// gradient is therefore a sum of the same form over the same S_lm.
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "core/magnetics/sources/source.h"

namespace loomstone {

class MultipoleExpansion {
 public:
  // Smallest distance from the origin, in radii of the body, at which a Polyhedron uses the
  // expansion.
  static constexpr double near = 4.0;
  static constexpr int degree = 24;  // highest degree of the potential; for errors: field_block()

  // `charges` are mu0 times magnetic charges [T m^2] at positions (n x 3) [m]. All positions must
  // lie within `radius` [m] of the origin. The net charge is taken to be zero.
  MultipoleExpansion(const Points& positions, const Vector& charges, double radius);

  // Returns the expansion of dipoles. `moments` (n x 3) are mu0 times dipole moments [T m^3].
  static MultipoleExpansion of_dipoles(const Points& positions, const Points& moments,
                                       double radius);

  // Computes mu0 H [T] or its gradient [T/m] at one block of points (see points_per_block). The
  // relative error is of the order of 1e-6 at 2 radii and of 1e-14 at `near` radii. Values closer
  // than 2 radii are meaningless.
  void field_block(const double* points, Index n, double* field) const;
  void gradient_block(const double* points, Index n, double* gradient) const;

 private:
  MultipoleExpansion(std::vector<std::complex<double>> moments, double radius);

  double radius_;
  // Coefficients of each component (real part, minus imaginary part) for l = 0 ... degree + 2,
  // m = 0 ... l. They multiply harmonics of positions in units of the radius.
  std::array<std::vector<double>, 3> field_;
  std::array<std::vector<double>, 6> gradient_;
};

}  // namespace loomstone
