// Field of a point dipole, equation (6.5) of [Thomaszewski2010], and the gradient of this field.
// The template parameter T selects between one dipole at eight points (T is double) and eight
// dipoles at one point (T is a lane vector).
#pragma once

#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

// Vector r from the dipole to the point, and the powers 1/R^2 and 1/R^3 of its length R, which are
// 0 if R = 0. If nearest2 > 0, dipole_arm() limits 1/R^3 to nearest2^(-3/2), but not 1/R^2.
template <class Lanes>
struct DipoleArm {
  Lanes3<Lanes> r;
  Lanes inverse2, inverse3;
};

template <class Lanes, class T>
LOOMSTONE_INLINE DipoleArm<Lanes> dipole_arm(const Lanes3<Lanes>& p, const T* position,
                                             double nearest2 = 0.0) {
  DipoleArm<Lanes> a;
  a.r = {p.x - position[0], p.y - position[1], p.z - position[2]};
  const Lanes square = dot(a.r, a.r);
  const Lanes inverse = 1.0 / square;
  a.inverse2 = lanes_select(square > 0.0, inverse, Lanes{});
  const Lanes capped =
      lanes_select(square < nearest2, lanes_all<Lanes>(1.0 / nearest2), a.inverse2);
  a.inverse3 = lanes_select(square > 0.0, capped * lanes_sqrt(capped), Lanes{});
  return a;
}

// Adds the field of a dipole m, divided by mu0/(4 pi), to `b`. `mr` is the dot product m.r.
template <class Lanes, class T>
LOOMSTONE_INLINE void add_dipole_field(const T* m, const DipoleArm<Lanes>& a, const Lanes& mr,
                                       Lanes3<Lanes>& b) {
  const Lanes along = 3.0 * mr * a.inverse2;
  b.x += (along * a.r.x - m[0]) * a.inverse3;
  b.y += (along * a.r.y - m[1]) * a.inverse3;
  b.z += (along * a.r.z - m[2]) * a.inverse3;
}

// Adds the gradient of the field of a dipole m, divided by 3 mu0/(4 pi), to `sum`. The order is xx,
// xy, xz, yy, yz, zz.
template <class Lanes, class T>
LOOMSTONE_INLINE void add_dipole_gradient(const T* m, const DipoleArm<Lanes>& a, const Lanes& mr,
                                          Lanes* sum) {
  const Lanes five = 5.0 * mr * a.inverse2, scale = a.inverse3 * a.inverse2;
  sum[0] += (2.0 * m[0] * a.r.x + mr - five * a.r.x * a.r.x) * scale;
  sum[1] += (m[0] * a.r.y + m[1] * a.r.x - five * a.r.x * a.r.y) * scale;
  sum[2] += (m[0] * a.r.z + m[2] * a.r.x - five * a.r.x * a.r.z) * scale;
  sum[3] += (2.0 * m[1] * a.r.y + mr - five * a.r.y * a.r.y) * scale;
  sum[4] += (m[1] * a.r.z + m[2] * a.r.y - five * a.r.y * a.r.z) * scale;
  sum[5] += (2.0 * m[2] * a.r.z + mr - five * a.r.z * a.r.z) * scale;
}

}  // namespace loomstone
