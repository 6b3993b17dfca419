// The coefficients with which implicit schemes weigh what enters a step.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace loomstone {

enum class Scheme { BackwardEuler, Midpoint, Bdf2 };

struct SchemeCoefficients {
  double c_d;    // of the damping D in the matrix [s]
  double c_k;    // of the stiffness K in the matrix [s^2]
  double sigma;  // of forces on the right side [s]
  double reach;  // displacement for a velocity that does not change, over that velocity [s]
  double time;   // from the start of the step to where forces are evaluated [s]
};

inline SchemeCoefficients coefficients(Scheme scheme, double h) {
  switch (scheme) {
    case Scheme::BackwardEuler:
      return {h, h * h, h, h, h};
    case Scheme::Midpoint:
      return {h / 2, h * h / 4, h, h / 2, h / 2};
    case Scheme::Bdf2:
      break;
  }
  return {2 * h / 3, 4 * h * h / 9, 2 * h / 3, 2 * h / 3, h};
}

// Free bodies move by h v+ whatever the cloth's scheme, because their stage is symplectic Euler,
// and feel the impulse h f. With forces evaluated at displacements of d v+ of bodies (d the time of
// the scheme), and of (c_k / sigma) y of any row with y its unknown, a body's unknown is
// y = sigma d / c_k dv, and the system stays symmetric with c_k / (h d) times its mass.
struct BodyRows {
  double mass_share;      // of the masses in the system
  double velocity_share;  // dv = velocity_share * y

  BodyRows(double h, const SchemeCoefficients& c)
      : mass_share(c.c_k / (h * c.time)), velocity_share(c.c_k / (c.sigma * c.time)) {}

  // Masses for the system.
  std::vector<Mat3> masses(const std::vector<Mat3>* given) const {
    std::vector<Mat3> scaled = given ? *given : std::vector<Mat3>();
    for (Mat3& mass : scaled) mass *= mass_share;
    return scaled;
  }
};

}  // namespace loomstone
