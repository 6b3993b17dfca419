// 18-DOPs ([Thomaszewski2010], (2.56)): extents along nine directions with components -1, 0 or 1.
// The three axes come first, then the six diagonals. Directions are not normalised. Bounds are
// floats, rounded outwards. Groups of eight 18-DOPs have a structure-of-arrays layout for vector
// instructions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/types.h"

namespace loomstone {

inline constexpr int n_slabs = 9, n_axis_slabs = 3, slab_lanes = 8;

struct Slabs {
  float low[n_slabs];
  float high[n_slabs];

  void include(const Slabs& other) {
    for (int k = 0; k < n_slabs; ++k) {
      low[k] = std::min(low[k], other.low[k]);
      high[k] = std::max(high[k], other.high[k]);
    }
  }
};

inline Slabs empty_slabs() {
  Slabs slabs;
  std::fill_n(slabs.low, n_slabs, std::numeric_limits<float>::infinity());
  std::fill_n(slabs.high, n_slabs, -std::numeric_limits<float>::infinity());
  return slabs;
}

inline bool overlapping(const Slabs& a, const Slabs& b) {
  for (int k = 0; k < n_slabs; ++k)
    if (a.low[k] > b.high[k] || b.low[k] > a.high[k]) return false;
  return true;
}

// Returns the slabs of a point that moves from x0 to x1. They are inflated so that the slabs of two
// points, both with this inflation, overlap whenever the points come within 2 * inflation [m] of
// each other.
inline Slabs slabs_of(const double* x0, const double* x1, double inflation) {
  // Relative and absolute margins, larger than the rounding error of a float.
  constexpr float outwards = 2.4e-7f, tiny = 1e-37f;
  const double across = inflation * 1.4142135623730952;
  Slabs slabs;
  const auto set = [&](int k, double a, double b, double grow) {
    const float low = static_cast<float>(std::min(a, b) - grow),
                high = static_cast<float>(std::max(a, b) + grow);
    slabs.low[k] = low - std::abs(low) * outwards - tiny;
    slabs.high[k] = high + std::abs(high) * outwards + tiny;
  };
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    set(k, x0[k], x1[k], inflation);
    set(3 + 2 * k, x0[k] + x0[l], x1[k] + x1[l], across);
    set(4 + 2 * k, x0[k] - x0[l], x1[k] - x1[l], across);
  }
  return slabs;
}

// Slabs for vector arithmetic: nine lower bounds, nine negated upper bounds, then zeros. With this
// sign convention, the smallest box around two boxes is their component-wise minimum. In an empty
// box, all values are positive infinity.
inline constexpr int n_slab_packs = 3;

struct alignas(32) PackedSlabs {
  float value[n_slab_packs * slab_lanes];
};

inline PackedSlabs empty_packed() {
  PackedSlabs none;
  std::fill_n(none.value, n_slab_packs * slab_lanes, std::numeric_limits<float>::infinity());
  return none;
}

inline PackedSlabs packed(const Slabs& slabs) {
  PackedSlabs result = {};
  for (int k = 0; k < n_slabs; ++k) {
    result.value[k] = slabs.low[k];
    result.value[n_slabs + k] = -slabs.high[k];
  }
  return result;
}

// Eight boxes in structure-of-arrays layout. Empty lanes overlap nothing.
struct alignas(32) SlabGroup {
  float low[n_slabs][slab_lanes];
  float high[n_slabs][slab_lanes];
};

}  // namespace loomstone
