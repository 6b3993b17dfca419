// Elementary functions on eight lanes: selection, logarithm, arc tangent. Errors below 2 units in the last place; no
// branches, so that every instruction set gives the same bits. Reductions and coefficients of logarithm and arc tangent
// are those of [fdlibm].
#pragma once

#include <limits>

#include "core/base/lane_vectors.h"

namespace loomstone {

typedef long long LaneMask __attribute__((vector_size(8 * n_lanes)));

LOOMSTONE_INLINE Lanes lanes_all(double a) { return Lanes{} + a; }
LOOMSTONE_INLINE LaneMask lanes_bits(const Lanes& a) { return (LaneMask)a; }  // casts of vectors keep the bits
LOOMSTONE_INLINE Lanes lanes_of_bits(const LaneMask& a) { return (Lanes)a; }
LOOMSTONE_INLINE Lanes lanes_select(const LaneMask& where, const Lanes& yes, const Lanes& no) {
  return where ? yes : no;
}
LOOMSTONE_INLINE Lanes lanes_abs(const Lanes& a) {
  const LaneMask bits = lanes_bits(a) & 0x7fffffffffffffffLL;
  return lanes_of_bits(bits);
}
LOOMSTONE_INLINE Lanes lanes_with_sign(const Lanes& size, const Lanes& sign) {
  const LaneMask bits =
      (lanes_bits(size) & 0x7fffffffffffffffLL) | (lanes_bits(sign) & std::numeric_limits<long long>::min());
  return lanes_of_bits(bits);
}
LOOMSTONE_INLINE Lanes lanes_min(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
LOOMSTONE_INLINE Lanes lanes_max(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
LOOMSTONE_INLINE bool lanes_any(const LaneMask& mask) {
  long long any = 0;
  for (int i = 0; i < n_lanes; ++i) any |= mask[i];
  return any != 0;
}

LOOMSTONE_INLINE double lanes_sum(const Lanes& a) {
  return ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]));
}

// Natural logarithm of normal positive numbers.
LOOMSTONE_INLINE Lanes lanes_log(const Lanes& value) {
  const LaneMask bits = lanes_bits(value);
  const LaneMask shifted =
      bits - 0x3fe6a09e667f3bcdLL;  // bits of sqrt(1/2): the mantissa below lies in [sqrt(1/2), sqrt(2))
  const LaneMask exponent = shifted >> 52;
  const LaneMask mantissa = bits - (exponent << 52);
  const Lanes f = lanes_of_bits(mantissa) - 1.0;
  const Lanes k = __builtin_convertvector(exponent, Lanes);
  const Lanes s = f / (2.0 + f), z = s * s, w = z * z;
  const Lanes t1 = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
  const Lanes t2 = z * (6.666666666666735130e-01 +
                        w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
  const Lanes half_square = 0.5 * f * f;
  return k * 6.93147180369123816490e-01 -
         ((half_square - (s * (half_square + (t1 + t2)) + k * 1.90821492927058770002e-10)) - f);
}

// Angle of (x, y) in (-pi, pi]; 0 for (0, 0).
LOOMSTONE_INLINE Lanes lanes_atan2(const Lanes& y, const Lanes& x) {
  const Lanes a = lanes_abs(y), b = lanes_abs(x);
  const LaneMask steep = a > b;
  const Lanes small = lanes_select(steep, b, a), large = lanes_select(steep, a, b);
  const LaneMask turned = small > 0.4142135623730950 * large;  // tan(pi/8): subtract pi/4
  Lanes below = lanes_select(turned, small + large, large);
  below = lanes_select(below > 0.0, below, lanes_all(1.0));
  const Lanes t = lanes_select(turned, small - large, small) / below;
  const Lanes z = t * t, w = z * z;
  const Lanes s1 = z * (3.33333333333329318027e-01 +
                        w * (1.42857142725034663711e-01 +
                             w * (9.09088713343650656196e-02 +
                                  w * (6.66107313738753120669e-02 +
                                       w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const Lanes s2 =
      w *
      (-1.99999999998764832476e-01 +
       w * (-1.11111104054623557880e-01 +
            w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  const Lanes zero = lanes_all(0.0);
  Lanes angle = lanes_select(turned, lanes_all(7.85398163397448278999e-01), zero) +
                ((t - t * (s1 + s2)) + lanes_select(turned, lanes_all(3.06161699786838301793e-17), zero));
  angle = lanes_select(steep, 1.57079632679489655800e+00 - (angle - 6.12323399573676603587e-17), angle);
  angle = lanes_select(x < 0.0, 3.14159265358979311600e+00 - (angle - 1.22464679914735317636e-16), angle);
  return lanes_with_sign(angle, y);
}

LOOMSTONE_INLINE Lanes norm(const Lanes3& a) { return lanes_sqrt(dot(a, a)); }

}  // namespace loomstone
