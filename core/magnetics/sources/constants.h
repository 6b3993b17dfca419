// Constants of magnetostatics.
#pragma once

#include <numbers>

namespace loomstone {

inline constexpr double pi = std::numbers::pi;
inline constexpr double mu0 =
    4e-7 * std::numbers::pi;  // permeability of vacuum [T m/A]; CODATA 2018 is 6e-10 of it higher

}  // namespace loomstone
