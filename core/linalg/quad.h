// A vector of four adjacent numbers, such as a row whose fourth number is zero.
#pragma once

#include "core/base/simd.h"

namespace loomstone {

typedef double Quad __attribute__((vector_size(32)));
typedef float FloatQuad __attribute__((vector_size(16)));

LOOMSTONE_INLINE Quad quad_load(const double* p) {
  Quad r;
  __builtin_memcpy(&r, p, sizeof(Quad));
  return r;
}

LOOMSTONE_INLINE void quad_store(double* p, const Quad& a) {
  __builtin_memcpy(p, &a, sizeof(Quad));
}

LOOMSTONE_INLINE FloatQuad quad_load(const float* p) {
  FloatQuad r;
  __builtin_memcpy(&r, p, sizeof(FloatQuad));
  return r;
}

LOOMSTONE_INLINE void quad_store(float* p, const FloatQuad& a) {
  __builtin_memcpy(p, &a, sizeof(FloatQuad));
}

// Returns the sum of the lanes, added in order.
LOOMSTONE_INLINE double quad_sum(const Quad& a) { return ((a[0] + a[1]) + a[2]) + a[3]; }

}  // namespace loomstone
