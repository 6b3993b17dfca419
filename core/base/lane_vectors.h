// 3-vectors in eight SIMD lanes, one vector per lane.
#pragma once

#include <cstddef>

#include "core/base/simd.h"
#include "core/base/types.h"

namespace loomstone {

template <class Lanes>
struct Lanes3 {
  Lanes x, y, z;
};

// Loads eight 3-vectors. Their x components begin at p, their y components at p + n, and their z
// components at p + 2 n.
template <class Lanes>
LOOMSTONE_INLINE Lanes3<Lanes> lanes3_load(const double* p, Index n) {
  return {lanes_load<Lanes>(p), lanes_load<Lanes>(p + n), lanes_load<Lanes>(p + 2 * n)};
}

// Gathers rows of an (n x 3) array, one per lane.
template <class Lanes>
LOOMSTONE_INLINE Lanes3<Lanes> lanes_gather(const Index* rows, const double* x) {
  const auto component = [&](int c) LOOMSTONE_INLINE_LAMBDA {
    return lanes_of<Lanes>([&](int l) LOOMSTONE_INLINE_LAMBDA {
      return x[3 * static_cast<std::size_t>(rows[l]) + c];
    });
  };
  return {component(0), component(1), component(2)};
}

template <class Lanes>
LOOMSTONE_INLINE Lanes3<Lanes> minus(const Lanes3<Lanes>& a, const Lanes3<Lanes>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Lanes>
LOOMSTONE_INLINE Lanes3<Lanes> combine(const Lanes3<Lanes>& a, const Lanes& s,
                                       const Lanes3<Lanes>& b, const Lanes& t) {
  return {a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t};
}
template <class Lanes>
LOOMSTONE_INLINE Lanes dot(const Lanes3<Lanes>& a, const Lanes3<Lanes>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Lanes>
LOOMSTONE_INLINE Lanes3<Lanes> cross(const Lanes3<Lanes>& a, const Lanes3<Lanes>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Lanes>
LOOMSTONE_INLINE Lanes norm(const Lanes3<Lanes>& a) {
  return lanes_sqrt(dot(a, a));
}

}  // namespace loomstone
