// Elementary functions on eight SIMD lanes: absolute value, copying of signs, logarithm and arc
// tangent. Errors are below 1 ulp (logarithm) and 3 ulp (arc tangent). There are no branches, and
// all instruction sets give bit-identical results. The coefficients are those of [fdlibm].
#pragma once

#include <limits>

#include "core/base/lane_vectors.h"

namespace loomstone {

// lanes_bits() reinterprets doubles as 64-bit integers, and lanes_of_bits() does the reverse.
template <class Lanes>
LOOMSTONE_INLINE MaskOf<Lanes> lanes_bits(const Lanes& a) {
  if constexpr (in_halves<Lanes>)
    return {lanes_bits(a.low), lanes_bits(a.high)};
  else
    return (MaskOf<Lanes>)a;  // a cast between vector types preserves the bits
}
template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_of_bits(const MaskOf<Lanes>& a) {
  if constexpr (in_halves<Lanes>)
    return {lanes_of_bits<typename Lanes::Half>(a.low),
            lanes_of_bits<typename Lanes::Half>(a.high)};
  else
    return (Lanes)a;
}
template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_abs(const Lanes& a) {
  return lanes_of_bits<Lanes>(lanes_bits(a) & 0x7fffffffffffffffLL);
}
template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_with_sign(const Lanes& size, const Lanes& sign) {
  return lanes_of_bits<Lanes>((lanes_bits(size) & 0x7fffffffffffffffLL) |
                              (lanes_bits(sign) & std::numeric_limits<long long>::min()));
}
// Returns k as a double, given the 64-bit integer 2^52 k with |k| <= 1024 (`bits`). The function
// avoids arithmetic 64-bit shifts and conversions from 64-bit integers, which AVX2 lacks.
template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_exponent(const MaskOf<Lanes>& bits) {
  if constexpr (in_halves<Lanes>) {
    return {lanes_exponent<typename Lanes::Half>(bits.low),
            lanes_exponent<typename Lanes::Half>(bits.high)};
  } else {
    typedef unsigned long long Bits __attribute__((vector_size(sizeof(Lanes))));
    const Bits biased = ((Bits)bits + 0x4000000000000000ULL) >> 52;  // k + 1024
    return (Lanes)(biased | 0x4330000000000000ULL) -
           4503599627371520.0;  // (2^52 + k + 1024) - (2^52 + 1024)
  }
}

// Returns the natural logarithm of normal positive numbers.
template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_log(const Lanes& value) {
  const MaskOf<Lanes> bits = lanes_bits(value);
  // Subtracting the bits of sqrt(1/2) makes the mantissa 1 + f lie in [sqrt(1/2), sqrt(2)).
  const MaskOf<Lanes> power = (bits - 0x3fe6a09e667f3bcdLL) & ~0xfffffffffffffLL;
  const Lanes f = lanes_of_bits<Lanes>(bits - power) - 1.0;
  const Lanes k = lanes_exponent<Lanes>(power);
  const Lanes s = f / (2.0 + f), z = s * s, w = z * z;
  const Lanes t1 = w * (3.999999999940941908e-01 +
                        w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
  const Lanes t2 = z * (6.666666666666735130e-01 +
                        w * (2.857142874366239149e-01 +
                             w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
  const Lanes half_square = 0.5 * f * f;
  return k * 6.93147180369123816490e-01 -
         ((half_square - (s * (half_square + (t1 + t2)) + k * 1.90821492927058770002e-10)) - f);
}

// Returns the angle of (x, y) in [-pi, pi], and 0 for (0, 0).
template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_atan2(const Lanes& y, const Lanes& x) {
  const Lanes a = lanes_abs(y), b = lanes_abs(x);
  const MaskOf<Lanes> steep = a > b;
  const Lanes small = lanes_select(steep, b, a), large = lanes_select(steep, a, b);
  // With phi = arctan(small / large), t is tan(phi - pi/4) if small / large exceeds tan(pi/8), and
  // otherwise tan(phi).
  const MaskOf<Lanes> turned = small > 0.4142135623730950 * large;
  Lanes below = lanes_select(turned, small + large, large);
  below = lanes_select(below > 0.0, below, lanes_all<Lanes>(1.0));
  const Lanes t = lanes_select(turned, small - large, small) / below;
  const Lanes z = t * t, w = z * z;
  const Lanes s1 =
      z * (3.33333333333329318027e-01 +
           w * (1.42857142725034663711e-01 +
                w * (9.09088713343650656196e-02 +
                     w * (6.66107313738753120669e-02 +
                          w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const Lanes s2 =
      w * (-1.99999999998764832476e-01 +
           w * (-1.11111104054623557880e-01 +
                w * (-7.69187620504482999495e-02 +
                     w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  const Lanes zero{};
  Lanes angle = lanes_select(turned, lanes_all<Lanes>(7.85398163397448278999e-01), zero) +
                ((t - t * (s1 + s2)) +
                 lanes_select(turned, lanes_all<Lanes>(3.06161699786838301793e-17), zero));
  angle =
      lanes_select(steep, 1.57079632679489655800e+00 - (angle - 6.12323399573676603587e-17), angle);
  angle = lanes_select(x < 0.0, 3.14159265358979311600e+00 - (angle - 1.22464679914735317636e-16),
                       angle);
  return lanes_with_sign(angle, y);
}

}  // namespace loomstone
