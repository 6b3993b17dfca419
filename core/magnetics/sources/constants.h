// Constants of magnetostatics.
#pragma once

#include <numbers>

namespace loomstone {

inline constexpr double pi = std::numbers::pi;
inline constexpr double mu0 =
    4e-7 * std::numbers::pi;  // permeability of vacuum, by the definition before 2019 [T m/A]

}  // namespace loomstone
