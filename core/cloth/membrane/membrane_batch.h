// A batch of eight triangles as the membrane's kernels read it.
#pragma once

#include "core/base/lane_vectors.h"
#include "core/cloth/membrane/membrane_kernels.h"

namespace loomstone::membrane {

template <class Lanes>
struct Batch {
  const Index* corners;
  const double* gradients;
  const double* constants;
  LOOMSTONE_INLINE Lanes gradient(int k) const { return lanes_load<Lanes>(gradients + 8 * k); }
  LOOMSTONE_INLINE Lanes constant(int k) const { return lanes_load<Lanes>(constants + 8 * k); }
};

template <class Lanes>
LOOMSTONE_INLINE Batch<Lanes> batch_of(const Tables& t, Index b) {
  const std::size_t i = static_cast<std::size_t>(b);
  return {t.corners + corner_stride * i, t.gradients + gradient_stride * i,
          t.constants + constant_stride * i};
}

// Columns of F (2.31); the sum over corners as differences to corner 2, since the gradients add up
// to zero.
template <class Lanes>
LOOMSTONE_INLINE void gradient_columns(const Batch<Lanes>& batch, const double* x,
                                       Lanes3<Lanes>& f1, Lanes3<Lanes>& f2) {
  const Lanes3<Lanes> x2 = lanes_gather<Lanes>(batch.corners + 16, x);
  const Lanes3<Lanes> e0 = minus(lanes_gather<Lanes>(batch.corners, x), x2);
  const Lanes3<Lanes> e1 = minus(lanes_gather<Lanes>(batch.corners + 8, x), x2);
  f1 = combine(e0, batch.gradient(0), e1, batch.gradient(2));
  f2 = combine(e0, batch.gradient(1), e1, batch.gradient(3));
}

// Null where nothing is added.
LOOMSTONE_INLINE const double* phase_of(const Tables& t, Index b) {
  return t.phase && t.in_phase[b] ? t.phase + phase_stride * static_cast<std::size_t>(b) : nullptr;
}
// What the second phase adds to a component of S where that of E is e, and its derivative.
template <class Lanes>
LOOMSTONE_INLINE Lanes phase_slope(const double* phase, int mode) {
  return lanes_load<Lanes>(phase + 8 * mode);
}
template <class Lanes>
LOOMSTONE_INLINE Lanes phase_stress(const double* phase, int mode, const Lanes& e) {
  return phase_slope<Lanes>(phase, mode) * e + lanes_load<Lanes>(phase + 8 * (3 + mode));
}
template <class Lanes>
LOOMSTONE_INLINE Lanes phase_energy(const double* phase, int mode, const Lanes& e) {
  return (0.5 * phase_slope<Lanes>(phase, mode) * e + lanes_load<Lanes>(phase + 8 * (3 + mode))) *
         e;
}

}  // namespace loomstone::membrane
