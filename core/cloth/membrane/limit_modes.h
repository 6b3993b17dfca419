// Limited strain modes of a triangle. Beyond the bounds of a mode, stiff phases of the membrane add
// energy.
#pragma once

#include <algorithm>
#include <array>
#include <limits>

namespace loomstone {

// The strain of a mode is e = d11 E11 + d22 E22 + 2 d12 E12, with the Green strain E. The second
// phase adds the energy density 1/2 modulus (e - bound)^2 beyond the bounds `low` and `high`.
// Beyond the bounds `far_low` and `far_high`, the third phase adds a term of the same form with a
// modulus that is `steeper` times as large.
struct LimitMode {
  static constexpr double steeper = 3.0;
  static constexpr double unlimited = std::numeric_limits<double>::infinity();
  double d11 = 0.0, d22 = 0.0, d12 = 0.0;
  double low = -unlimited, high = unlimited;
  double far_low = -unlimited, far_high = unlimited;
  double modulus = 0.0;  // [N/m]

  double strain(double e11, double e22, double e12) const {
    return d11 * e11 + d22 * e22 + 2.0 * d12 * e12;
  }
  double stress(double e) const {
    return modulus * (std::max(0.0, e - high) - std::max(0.0, low - e) +
                      steeper * (std::max(0.0, e - far_high) - std::max(0.0, far_low - e)));
  }
  // Number of stiff phases that have begun at the strain e: 0, 1 or 2.
  int phase(double e) const {
    return (e > high || e < low ? 1 : 0) + (e > far_high || e < far_low ? 1 : 0);
  }
};
using LimitModes = std::array<LimitMode, 3>;

}  // namespace loomstone
