// A batch of eight triangles in the form that the membrane kernels read, and functions that compute
// its strain, stress and energy. Equation numbers are those of [Thomaszewski2010].
#pragma once

#include "core/base/lane_vectors.h"
#include "core/cloth/membrane/limit_modes.h"
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

// Columns of F (2.31). The gradients of the shape functions sum to zero, so it suffices to use
// positions relative to corner 2.
template <class Lanes>
LOOMSTONE_INLINE void gradient_columns(const Batch<Lanes>& batch, const double* x,
                                       Lanes3<Lanes>& f1, Lanes3<Lanes>& f2) {
  const Lanes3<Lanes> x2 = lanes_gather<Lanes>(batch.corners + 16, x);
  const Lanes3<Lanes> e0 = minus(lanes_gather<Lanes>(batch.corners, x), x2);
  const Lanes3<Lanes> e1 = minus(lanes_gather<Lanes>(batch.corners + 8, x), x2);
  f1 = combine(e0, batch.gradient(0), e1, batch.gradient(2));
  f2 = combine(e0, batch.gradient(1), e1, batch.gradient(3));
}

// Green strain E or second Piola-Kirchhoff stress S in weft/warp axes.
template <class Lanes>
struct Tensor {
  Lanes t11, t22, t12;
};

template <class Lanes>
LOOMSTONE_INLINE Tensor<Lanes> green_strain(const Lanes3<Lanes>& f1, const Lanes3<Lanes>& f2) {
  return {0.5 * (dot(f1, f1) - 1.0), 0.5 * (dot(f2, f2) - 1.0), 0.5 * dot(f1, f2)};
}

// Plane-stress constants, equation (2.22).
template <class Lanes>
struct Moduli {
  Lanes a11, a22, a12, g;
};
template <class Lanes>
LOOMSTONE_INLINE Moduli<Lanes> moduli(const Batch<Lanes>& batch) {
  return {batch.constant(1), batch.constant(2), batch.constant(3), batch.constant(4)};
}
template <class Lanes>
LOOMSTONE_INLINE Tensor<Lanes> elastic_stress(const Moduli<Lanes>& m, const Tensor<Lanes>& e) {
  return {m.a11 * e.t11 + m.a12 * e.t22, m.a22 * e.t22 + m.a12 * e.t11,
          2.0 * m.g * e.t12};  // (2.23)
}

// Density of the elastic energy (2.21).
template <class Lanes>
LOOMSTONE_INLINE Lanes energy_density(const Moduli<Lanes>& m, const Tensor<Lanes>& e) {
  return 0.5 * (m.a11 * e.t11 * e.t11 + m.a22 * e.t22 * e.t22) + m.a12 * e.t11 * e.t22 +
         2.0 * m.g * e.t12 * e.t12;
}

// Returns 1/2 dF^T dF for a displacement with the gradient dF = (d1, d2).
template <class Lanes>
LOOMSTONE_INLINE Tensor<Lanes> second_order_strain(const Lanes3<Lanes>& d1,
                                                   const Lanes3<Lanes>& d2) {
  return {0.5 * dot(d1, d1), 0.5 * dot(d2, d2), 0.5 * dot(d1, d2)};
}

template <class Lanes>
LOOMSTONE_INLINE Lanes largest_eigenvalue(const Tensor<Lanes>& e) {
  const Lanes d = 0.5 * (e.t11 - e.t22);
  return 0.5 * (e.t11 + e.t22) + lanes_sqrt(d * d + e.t12 * e.t12);
}

// Returns the positive part of a symmetric tensor with the eigenvalues m + r and m - r.
template <class Lanes>
LOOMSTONE_INLINE Tensor<Lanes> positive_part(const Tensor<Lanes>& s) {
  const Lanes m = 0.5 * (s.t11 + s.t22), d = 0.5 * (s.t11 - s.t22);
  const Lanes r = lanes_sqrt(d * d + s.t12 * s.t12);
  const Lanes high = lanes_max0(m + r), low = lanes_max0(m - r);
  const Lanes mean = 0.5 * (high + low), share = 0.5 * (high - low) / (r + 1e-300);
  return {mean + share * d, mean - share * d, share * s.t12};
}

// Returns the table of the stiff phases of a batch, or null if none of its triangles is in a stiff
// phase.
LOOMSTONE_INLINE const double* phase_of(const Tables& t, Index b) {
  return t.phase && t.in_phase[b] ? t.phase + phase_stride * static_cast<std::size_t>(b) : nullptr;
}
// The next three functions describe the stress that stiff phases add in one mode, as a linear
// function of one component e of the Green strain (mode 0: E11, 1: E22, 2: E12). They return the
// slope of this function, its value at e, and its integral from 0 to e.
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
template <class Lanes>
LOOMSTONE_INLINE void add_phase_stress(const double* phase, const Tensor<Lanes>& e,
                                       Tensor<Lanes>& s) {
  s.t11 += phase_stress(phase, 0, e.t11);
  s.t22 += phase_stress(phase, 1, e.t22);
  s.t12 += phase_stress(phase, 2, e.t12);
}

// Result of beyond_limits(): strain of a mode beyond the bounds at which its second and third
// phases begin. It is negative below a lower bound and 0 between the bounds.
template <class Lanes>
struct Beyond {
  Lanes second, third;
};
// Evaluates one mode at the Green strain e. `mode` points to the table of the mode.
template <class Lanes>
LOOMSTONE_INLINE Beyond<Lanes> beyond_limits(const double* mode, const Tensor<Lanes>& e) {
  const auto at = [&](int k) LOOMSTONE_INLINE_LAMBDA { return lanes_load<Lanes>(mode + 8 * k); };
  const Lanes strain = at(0) * e.t11 + at(1) * e.t22 + 2.0 * (at(2) * e.t12);
  return {lanes_max0(strain - at(4)) - lanes_max0(at(3) - strain),
          lanes_max0(strain - at(6)) - lanes_max0(at(5) - strain)};
}
// Sets the bits of the lanes in which `beyond` is not zero.
template <class Lanes>
LOOMSTONE_INLINE void add_bits(const Lanes& beyond, std::uint8_t& bits) {
  for (int l = 0; l < n_lanes; ++l)
    if (beyond[l] != 0.0) bits |= static_cast<std::uint8_t>(1 << l);
}
// Adds the stress of the limit potential in batch b. Unless t.entered is null, also sets in
// t.entered the bits of the phases that have begun.
template <class Lanes>
LOOMSTONE_INLINE void add_limit_stress(const Tables& t, Index b, const Tensor<Lanes>& e,
                                       Tensor<Lanes>& s) {
  const double* mode = t.limits + limit_stride * static_cast<std::size_t>(b);
  for (int k = 0; k < 3; ++k, mode += mode_stride) {
    const Beyond<Lanes> beyond = beyond_limits(mode, e);
    if (!lanes_any((beyond.second > 0.0) | (beyond.second < 0.0))) continue;
    const Lanes stress =
        lanes_load<Lanes>(mode + 56) * (beyond.second + LimitMode::steeper * beyond.third);
    s.t11 += stress * lanes_load<Lanes>(mode);
    s.t22 += stress * lanes_load<Lanes>(mode + 8);
    s.t12 += stress * lanes_load<Lanes>(mode + 16);
    if (!t.entered) continue;
    std::uint8_t* bits = t.entered + entered_stride * static_cast<std::size_t>(b) + 2 * k;
    add_bits(beyond.second, bits[0]);
    add_bits(beyond.third, bits[1]);
  }
}
// Returns the energy density of the limit potential in batch b.
template <class Lanes>
LOOMSTONE_INLINE Lanes limit_energy(const Tables& t, Index b, const Tensor<Lanes>& e) {
  const double* mode = t.limits + limit_stride * static_cast<std::size_t>(b);
  Lanes energy{};
  for (int k = 0; k < 3; ++k, mode += mode_stride) {
    const Beyond<Lanes> beyond = beyond_limits(mode, e);
    energy += 0.5 * lanes_load<Lanes>(mode + 56) *
              (beyond.second * beyond.second + LimitMode::steeper * (beyond.third * beyond.third));
  }
  return energy;
}

}  // namespace loomstone::membrane
