// Bulirsch's general complete elliptic integral [Bulirsch1969] on eight SIMD lanes,
//   cel(kc, p, a, b) = int_0^{pi/2} (a c^2 + b s^2) / (c^2 + p s^2) / sqrt(c^2 + kc^2 s^2) dtheta
// with c = cos theta, s = sin theta and kc, p > 0. The function evaluates `count` pairs (a, b) at
// once, returns the integrals in `a` and overwrites `b`. The iteration converges in nine steps for
// kc >= 1e-16. All lanes take nine steps, so the result of a lane does not depend on its
// neighbours.
#pragma once

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

template <int count, class Lanes>
LOOMSTONE_INLINE void elliptic(const Lanes& kc, const Lanes& p, Lanes* a, Lanes* b) {
  Lanes k = kc, root = lanes_sqrt(p), mean = lanes_all<Lanes>(1.0), product;
  Lanes g = k / root;
  for (int i = 0; i < count; ++i) {
    b[i] /= root;
    const Lanes before = a[i];
    a[i] += b[i] / root;
    b[i] = 2.0 * (b[i] + before * g);
  }
  root += g;
  mean += k;
  product = k;
  for (int step = 0; step < 8; ++step) {
    k = 2.0 * lanes_sqrt(product);
    product = k * mean;
    const Lanes inverse = 1.0 / root;
    g = product * inverse;
    for (int i = 0; i < count; ++i) {
      const Lanes before = a[i];
      a[i] += b[i] * inverse;
      b[i] = 2.0 * (b[i] + before * g);
    }
    root += g;
    mean += k;
  }
  const Lanes scale = 0.5 * pi / (mean * (mean + root));
  for (int i = 0; i < count; ++i) a[i] = (b[i] + a[i] * mean) * scale;
}

}  // namespace loomstone
