// Vectors of three components in eight lanes.
#pragma once

#include <cstddef>

#include "core/base/simd.h"
#include "core/base/types.h"

namespace loomstone {

struct Lanes3 {
  Lanes x, y, z;
};

// Rows of an (n x 3) array, one a lane.
LOOMSTONE_INLINE Lanes3 lanes_gather(const Index* rows, const double* x) {
  Lanes3 r;
  for (int l = 0; l < n_lanes; ++l) {
    const double* p = x + 3 * static_cast<std::size_t>(rows[l]);
    r.x[l] = p[0];
    r.y[l] = p[1];
    r.z[l] = p[2];
  }
  return r;
}

LOOMSTONE_INLINE Lanes3 minus(const Lanes3& a, const Lanes3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
LOOMSTONE_INLINE Lanes3 combine(const Lanes3& a, const Lanes& s, const Lanes3& b, const Lanes& t) {
  return {a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t};
}
LOOMSTONE_INLINE Lanes dot(const Lanes3& a, const Lanes3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
LOOMSTONE_INLINE Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace loomstone
