// Coefficients of the implicit schemes.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace loomstone {

enum class Scheme { BackwardEuler, Midpoint, Bdf2 };

struct SchemeCoefficients {
  double c_d;    // factor of the damping D in the matrix [s]
  double c_k;    // factor of the stiffness K in the matrix [s^2]
  double sigma;  // factor of forces on the right-hand side [s]
  double reach;  // factor of v in the displacement at which forces are evaluated if dv = 0 [s]
  double time;   // time from the start of the step to the evaluation of forces [s]
  // Factor b of BDF-2, which multiplies the displacement and the change of velocity of the last
  // step [1]. It is 0 for the other schemes.
  double history = 0.0;
};

// `ratio` (for BDF-2 only) is r = h / h_, where h_ is the length of the last step. For y' = f(y),
// BDF-2 computes the value y+ at the end of the step from y at its start and y_ one step earlier:
//   y+ = y + b (y - y_) + B h f(y+) with b = r^2 / (1 + 2 r) and B = (1 + r) / (1 + 2 r).
inline SchemeCoefficients coefficients(Scheme scheme, double h, double ratio = 1.0) {
  switch (scheme) {
    case Scheme::BackwardEuler:
      return {h, h * h, h, h, h};
    case Scheme::Midpoint:
      return {h / 2, h * h / 4, h, h / 2, h / 2};
    case Scheme::Bdf2:
      break;
  }
  const double reach = (1 + ratio) / (1 + 2 * ratio) * h;
  return {reach, reach * reach, reach, reach, h, ratio * ratio / (1 + 2 * ratio)};
}

// Scaling of the rows of rigid bodies in the linear system. For every scheme, bodies move by
// symplectic Euler: they receive the impulse h f of the force f, and then move by h v+ at the new
// velocity v+ = v + dv. Let d be the `time` of the scheme. Forces on a body must be evaluated at
// its displacement d v + d dv, but the system evaluates them at d v + (c_k / sigma) y in a row with
// the unknown y. The unknown of a body is therefore y = (sigma d / c_k) dv. The system stays
// symmetric if the mass of the body is multiplied by c_k / (h d).
struct BodyRows {
  double mass_share;      // factor of masses in the system [1]
  double velocity_share;  // dv = velocity_share * y [1]

  BodyRows(double h, const SchemeCoefficients& c)
      : mass_share(c.c_k / (h * c.time)), velocity_share(c.c_k / (c.sigma * c.time)) {}

  // Returns the given masses multiplied by `mass_share`, or no masses if `given` is null.
  std::vector<Mat3> masses(const std::vector<Mat3>* given) const {
    std::vector<Mat3> scaled = given ? *given : std::vector<Mat3>();
    for (Mat3& mass : scaled) mass *= mass_share;
    return scaled;
  }
};

}  // namespace loomstone
