// Constants of magnetostatics.
#pragma once

#include <numbers>

namespace loomstone {

inline constexpr double pi = std::numbers::pi;
// Vacuum permeability [T m/A]. The CODATA 2018 value is larger by a fraction of 5e-10.
inline constexpr double mu0 = 4e-7 * std::numbers::pi;

}  // namespace loomstone
