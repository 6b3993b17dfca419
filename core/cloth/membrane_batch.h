// A batch of eight triangles as the membrane's kernels read it.
#pragma once

#include "core/base/lane_vectors.h"
#include "core/cloth/membrane_kernels.h"

namespace loomstone::membrane {

struct Batch {
  const Index* corners;
  const double* gradients;
  const double* constants;
  LOOMSTONE_INLINE Lanes gradient(int k) const { return lanes_load(gradients + 8 * k); }
  LOOMSTONE_INLINE Lanes constant(int k) const { return lanes_load(constants + 8 * k); }
};

LOOMSTONE_INLINE Batch batch_of(const Tables& t, Index b) {
  const std::size_t i = static_cast<std::size_t>(b);
  return {t.corners + corner_stride * i, t.gradients + gradient_stride * i, t.constants + constant_stride * i};
}

// Columns of F (2.31); the sum over corners as differences to corner 2, since the gradients add up to zero.
LOOMSTONE_INLINE void gradient_columns(const Batch& batch, const double* x, Lanes3& f1, Lanes3& f2) {
  const Lanes3 x2 = lanes_gather(batch.corners + 16, x);
  const Lanes3 e0 = minus(lanes_gather(batch.corners, x), x2);
  const Lanes3 e1 = minus(lanes_gather(batch.corners + 8, x), x2);
  f1 = combine(e0, batch.gradient(0), e1, batch.gradient(2));
  f2 = combine(e0, batch.gradient(1), e1, batch.gradient(3));
}

// Null where nothing is added.
LOOMSTONE_INLINE const double* phase_of(const Tables& t, Index b) {
  return t.phase && t.in_phase[b] ? t.phase + phase_stride * static_cast<std::size_t>(b) : nullptr;
}
// What the second phase adds to a component of S where that of E is e, and its derivative.
LOOMSTONE_INLINE Lanes phase_slope(const double* phase, int mode) { return lanes_load(phase + 8 * mode); }
LOOMSTONE_INLINE Lanes phase_stress(const double* phase, int mode, const Lanes& e) {
  return phase_slope(phase, mode) * e + lanes_load(phase + 8 * (3 + mode));
}
LOOMSTONE_INLINE Lanes phase_energy(const double* phase, int mode, const Lanes& e) {
  return (0.5 * phase_slope(phase, mode) * e + lanes_load(phase + 8 * (3 + mode))) * e;
}

}  // namespace loomstone::membrane
