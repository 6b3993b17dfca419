// Converts a mask of eight SIMD lanes to the bits of an integer.
#pragma once

#include "core/base/simd.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace loomstone {

// Returns an integer whose bit i is set if lane i of `mask` is true. gcc 12 would compile a loop
// over lanes to many instructions. On x86-64, the instructions used here convert a whole register
// at once.
template <class Mask>
LOOMSTONE_INLINE unsigned lanes_bits(const Mask& mask) {
  constexpr bool wide = sizeof(typename VectorTypes<Mask>::Scalar) == 8;
  if constexpr (in_halves<Mask>) {
    return lanes_bits(mask.low) | lanes_bits(mask.high) << Mask::size;
#if LOOMSTONE_SEVERAL_SETS
  } else if constexpr (wide && sizeof(Mask) == 64) {
    return static_cast<unsigned>(__builtin_ia32_cvtq2mask512((__v8di)mask)) & 0xffu;
  } else if constexpr (wide && sizeof(Mask) == 32) {
    return static_cast<unsigned>(__builtin_ia32_movmskpd256((__v4df)mask));
  } else if constexpr (!wide && sizeof(Mask) == 32) {
    return static_cast<unsigned>(__builtin_ia32_movmskps256((__v8sf)mask));
#endif
#if defined(__x86_64__)
  } else if constexpr (sizeof(Mask) == 16) {
    return static_cast<unsigned>(wide ? _mm_movemask_pd((__m128d)mask)
                                      : _mm_movemask_ps((__m128)mask));
#endif
  } else {
    unsigned bits = 0;
    for (unsigned i = 0; i < sizeof(Mask) / sizeof(mask[0]); ++i) bits |= (mask[i] != 0) << i;
    return bits;
  }
}

}  // namespace loomstone
