// Comparison of tables of positions or velocities that are usually equal.
#pragma once

#include <cstring>

#include "core/base/types.h"

namespace loomstone {

// Returns whether two tables have the same rows, bit by bit. The signs of zeros count, and equal
// NaNs are the same.
inline bool same_bits(const Points& a, const Points& b) {
  return a.rows() == b.rows() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

}  // namespace loomstone
