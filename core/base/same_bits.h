// Bitwise comparison of tables of positions or velocities.
#pragma once

#include <cstring>

#include "core/base/types.h"

namespace loomstone {

// Returns whether two tables are bitwise equal. Zeros of different sign differ, and NaNs with the
// same bits are equal.
inline bool same_bits(const Points& a, const Points& b) {
  const std::size_t n_bytes = sizeof(double) * static_cast<std::size_t>(a.size());
  return a.rows() == b.rows() && (n_bytes == 0 || std::memcmp(a.data(), b.data(), n_bytes) == 0);
}

}  // namespace loomstone
