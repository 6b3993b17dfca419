// Eight doubles worked at once. Kernels are written once on Lanes and compiled for three instruction sets; the best one is
// chosen when the program starts. All give the same bits (no contraction, no reordered sums).
#pragma once

#include <cmath>

namespace loomstone {

inline constexpr int n_lanes = 8;

typedef double Lanes __attribute__((vector_size(8 * n_lanes)));

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(__clang__) || !defined(__x86_64__)
#define LOOMSTONE_CLONES
#else
#define LOOMSTONE_CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#endif
#define LOOMSTONE_INLINE inline __attribute__((always_inline))

LOOMSTONE_INLINE Lanes lanes_sqrt(const Lanes& a) {
  Lanes r;
  for (int i = 0; i < n_lanes; ++i) r[i] = __builtin_sqrt(a[i]);
  return r;
}

LOOMSTONE_INLINE Lanes lanes_max0(const Lanes& a) {
  Lanes r;
  for (int i = 0; i < n_lanes; ++i) r[i] = a[i] > 0.0 ? a[i] : 0.0;
  return r;
}

LOOMSTONE_INLINE Lanes lanes_load(const double* p) {
  Lanes r;
  __builtin_memcpy(&r, p, sizeof(Lanes));
  return r;
}

LOOMSTONE_INLINE void lanes_store(double* p, const Lanes& a) { __builtin_memcpy(p, &a, sizeof(Lanes)); }

}  // namespace loomstone
