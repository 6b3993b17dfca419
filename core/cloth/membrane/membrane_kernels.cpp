#include "core/cloth/membrane/membrane_kernels.h"

#include "core/cloth/membrane/membrane_batch.h"

namespace loomstone::membrane {

namespace {

template <class Lanes>
LOOMSTONE_INLINE void store(double* out, int k, const Lanes& value) {
  lanes_store(out + 8 * k, value);
}

// Stores the nine numbers of each lane's block contiguously. The first eight numbers result from an
// 8 x 8 transposition.
template <class Lanes>
LOOMSTONE_INLINE void store_blocks(double* out, const Lanes a[9]) {
  Lanes b[8], c[8];
  for (int i = 0; i < 8; i += 2) {
    b[i] = lanes_shuffle<0, 8, 2, 10, 4, 12, 6, 14>(a[i], a[i + 1]);
    b[i + 1] = lanes_shuffle<1, 9, 3, 11, 5, 13, 7, 15>(a[i], a[i + 1]);
  }
  for (int i = 0; i < 8; i += 4)
    for (int k = 0; k < 2; ++k) {
      c[i + k] = lanes_shuffle<0, 1, 8, 9, 4, 5, 12, 13>(b[i + k], b[i + k + 2]);
      c[i + k + 2] = lanes_shuffle<2, 3, 10, 11, 6, 7, 14, 15>(b[i + k], b[i + k + 2]);
    }
  for (int k = 0; k < 4; ++k) {
    lanes_store(out + lane_stride * k, lanes_shuffle<0, 1, 2, 3, 8, 9, 10, 11>(c[k], c[k + 4]));
    lanes_store(out + lane_stride * (k + 4),
                lanes_shuffle<4, 5, 6, 7, 12, 13, 14, 15>(c[k], c[k + 4]));
  }
  for (int l = 0; l < n_lanes; ++l) out[lane_stride * l + 8] = a[8][l];
}

}  // namespace

template <class Lanes>
LOOMSTONE_INLINE void forces(const Tables& tables, const Index* batches, Index n, const double* x,
                             const double* v, double* out) {
  for (Index i = 0; i < n; ++i) {
    const Batch<Lanes> batch = batch_of<Lanes>(tables, batches[i]);
    Lanes3<Lanes> f1, f2;
    gradient_columns(batch, x, f1, f2);
    const Tensor<Lanes> e = green_strain(f1, f2);
    Tensor<Lanes> s = elastic_stress(moduli(batch), e);
    if (const double* phase = phase_of(tables, batches[i])) add_phase_stress(phase, e, s);
    if (tables.limits) add_limit_stress(tables, batches[i], e, s);
    if (v) {
      Lanes3<Lanes> d1, d2;  // columns of dF/dt
      gradient_columns(batch, v, d1, d2);
      // Mean strain rate r over the time t = rate_time, with the deformation gradient F at x:
      //   t r = E(x) - E(x - t v) = t sym(F^T dF/dt) - t^2 / 2 dF/dt^T dF/dt.
      const double half = 0.5 * tables.rate_time;
      const Lanes r11 = dot(d1, f1) - half * dot(d1, d1), r22 = dot(d2, f2) - half * dot(d2, d2),
                  r12 = 0.5 * (dot(d1, f2) + dot(d2, f1)) - half * dot(d1, d2);
      const Lanes lambda = batch.constant(5), mu = batch.constant(6);
      const Lanes trace = lambda * (r11 + r22);
      s.t11 += trace + 2.0 * mu * r11;
      s.t22 += trace + 2.0 * mu * r22;
      s.t12 += 2.0 * mu * r12;
    }
    const Lanes minus_area = -batch.constant(0);
    const Lanes3<Lanes> p1 =
        combine(f1, minus_area * s.t11, f2, minus_area * s.t12);  // columns of -A F S
    const Lanes3<Lanes> p2 = combine(f1, minus_area * s.t12, f2, minus_area * s.t22);
    const Lanes3<Lanes> force0 = combine(p1, batch.gradient(0), p2, batch.gradient(1));
    const Lanes3<Lanes> force1 = combine(p1, batch.gradient(2), p2, batch.gradient(3));
    double* o = out + force_stride * static_cast<std::size_t>(batches[i]);
    store(o, 0, force0.x), store(o, 1, force0.y), store(o, 2, force0.z);
    store(o, 3, force1.x), store(o, 4, force1.y), store(o, 5, force1.z);
    store(o, 6, -(force0.x + force1.x)), store(o, 7, -(force0.y + force1.y)),
        store(o, 8, -(force0.z + force1.z));
  }
}
void forces(const Tables& tables, const Index* batches, Index n, const double* x, const double* v,
            double* out) {
  LOOMSTONE_WIDEST(forces)(tables, batches, n, x, v, out);
}

// Bound on the largest eigenvalue of the strain 1/2 dF^T dF of the past motion [1]. A larger strain
// is scaled down to the bound. The geometric stiffness omits the stress of the resulting strain.
// Our choice: a smaller bound makes stiff sheets move too slowly, and a larger one reduces the
// damping of snapping wrinkles.
constexpr double most_left_out = 0.01;

template <class Lanes>
LOOMSTONE_INLINE Tensor<Lanes> past_strain(const Batch<Lanes>& batch, const PastMotion& past) {
  Lanes3<Lanes> d1, d2;
  gradient_columns(batch, past.motion, d1, d2);
  const Tensor<Lanes> rate = second_order_strain(d1, d2);
  const double square = past.step * past.step;
  const Lanes most = lanes_of<Lanes>([](int) LOOMSTONE_INLINE_LAMBDA { return most_left_out; });
  const Lanes share = square * (most / lanes_max(most, square * largest_eigenvalue(rate)));
  return {share * rate.t11, share * rate.t22, share * rate.t12};
}

// Returns the stress in the geometric stiffness. `strain` is the Green strain at the positions of
// the assembly; `phase` is null if the batch is in no limit phase.
template <class Lanes>
LOOMSTONE_INLINE Tensor<Lanes> geometric_stress(const Batch<Lanes>& batch, const double* phase,
                                                const Tensor<Lanes>& strain,
                                                const JacobianTerms& terms) {
  Tensor<Lanes> e = strain;
  if (terms.past.at) {
    Lanes3<Lanes> f1, f2;
    gradient_columns(batch, terms.past.at, f1, f2);
    e = green_strain(f1, f2);
  }
  Tensor<Lanes> s = elastic_stress(moduli(batch), e);
  if (phase) add_phase_stress(phase, e, s);
  if (terms.past.motion) {
    const Tensor<Lanes> left_out = elastic_stress(moduli(batch), past_strain(batch, terms.past));
    s = {s.t11 - left_out.t11, s.t22 - left_out.t22, s.t12 - left_out.t12};
  }
  return terms.kind == JacobianKind::Positive ? positive_part(s) : s;
}

template <class Lanes>
LOOMSTONE_INLINE void blocks(const Tables& tables, const Index* batches, Index n, const double* x,
                             JacobianTerms terms, double* out) {
  for (Index i = 0; i < n; ++i) {
    const Batch<Lanes> batch = batch_of<Lanes>(tables, batches[i]);
    Lanes3<Lanes> f1, f2;
    gradient_columns(batch, x, f1, f2);
    const Lanes area = batch.constant(0);
    Moduli<Lanes> m = moduli(batch);
    const double* const phase = phase_of(tables, batches[i]);
    if (phase)
      m.a11 += phase_slope<Lanes>(phase, 0), m.a22 += phase_slope<Lanes>(phase, 1),
          m.g += 0.5 * phase_slope<Lanes>(phase, 2);
    const Tensor<Lanes> s = geometric_stress(batch, phase, green_strain(f1, f2), terms);
    const double scale_k = terms.scales.elastic, scale_d = terms.scales.viscous;
    const Lanes k_area = scale_k * area;
    const Lanes s11 = s.t11 * k_area, s22 = s.t22 * k_area, s12 = s.t12 * k_area;
    // The elastic moduli dS/dE and the viscous moduli dS/d(dE/dt) multiply the same derivatives of
    // E, so they are summed first.
    const Lanes lambda = scale_d * batch.constant(5), mu = scale_d * batch.constant(6);
    const Lanes a11 = area * (scale_k * m.a11 + lambda + 2.0 * mu);
    const Lanes a22 = area * (scale_k * m.a22 + lambda + 2.0 * mu);
    const Lanes a12 = area * (scale_k * m.a12 + lambda);
    const Lanes g = area * (scale_k * m.g + mu);
    const Lanes xx = f1.x * f1.x, xy = f1.x * f1.y, xz = f1.x * f1.z, yy = f1.y * f1.y,
                yz = f1.y * f1.z,
                zz = f1.z * f1.z;  // F1 F1^T
    const Lanes ux = f2.x * f2.x, uy = f2.x * f2.y, uz = f2.x * f2.z, vy = f2.y * f2.y,
                vz = f2.y * f2.z,
                wz = f2.z * f2.z;                                         // F2 F2^T
    const Lanes m00 = f1.x * f2.x, m01 = f1.x * f2.y, m02 = f1.x * f2.z;  // F1 F2^T
    const Lanes m10 = f1.y * f2.x, m11 = f1.y * f2.y, m12 = f1.y * f2.z;
    const Lanes m20 = f1.z * f2.x, m21 = f1.z * f2.y, m22 = f1.z * f2.z;
    for (int p = 0; p < 3; ++p) {
      const int q = (p + 1) % 3;
      const Lanes ix = batch.gradient(2 * p), iy = batch.gradient(2 * p + 1);
      const Lanes kx = batch.gradient(2 * q), ky = batch.gradient(2 * q + 1);
      const Lanes c11 = a11 * kx * ix + g * ky * iy, c12 = a12 * ky * ix + g * kx * iy;
      const Lanes c21 = a12 * kx * iy + g * ky * ix, c22 = a22 * ky * iy + g * kx * ix;
      const Lanes geometric = kx * (s11 * ix + s12 * iy) + ky * (s12 * ix + s22 * iy);
      const Lanes block[9] = {c11 * xx + c22 * ux + (c12 + c21) * m00 + geometric,
                              c11 * xy + c22 * uy + c12 * m10 + c21 * m01,  // row 1, column 0
                              c11 * xz + c22 * uz + c12 * m20 + c21 * m02,
                              c11 * xy + c22 * uy + c12 * m01 + c21 * m10,  // row 0, column 1
                              c11 * yy + c22 * vy + (c12 + c21) * m11 + geometric,
                              c11 * yz + c22 * vz + c12 * m21 + c21 * m12,
                              c11 * xz + c22 * uz + c12 * m02 + c21 * m20,
                              c11 * yz + c22 * vz + c12 * m12 + c21 * m21,
                              c11 * zz + c22 * wz + (c12 + c21) * m22 + geometric};
      store_blocks(out + block_stride * static_cast<std::size_t>(i) + pair_stride * p, block);
    }
  }
}
void blocks(const Tables& tables, const Index* batches, Index n, const double* x,
            JacobianTerms terms, double* out) {
  LOOMSTONE_WIDEST(blocks)(tables, batches, n, x, terms, out);
}

template <class Lanes>
LOOMSTONE_INLINE void rows(Index n, const Index* row_start, const Index* diagonal,
                           const Index* sources, const double* elements, double* values) {
  for (Index row = 0; row < n; ++row) {
    Lanes sum{};
    double last = 0.0;
    for (std::size_t k = row_start[row]; k < static_cast<std::size_t>(row_start[row + 1]); ++k) {
      const double *a = elements + sources[2 * k], *b = elements + sources[2 * k + 1];
      const Lanes other = lanes_load<Lanes>(b);
      const Lanes v = lanes_load<Lanes>(a) + lanes_shuffle<0, 3, 6, 1, 4, 7, 2, 5>(other, other);
      const double v8 = a[8] + b[8];
      lanes_store(values + 9 * k, v);
      values[9 * k + 8] = v8;
      sum += v;
      last += v8;
    }
    double s[9];
    lanes_store(s, sum);
    s[8] = last;
    double* d = values + 9 * static_cast<std::size_t>(diagonal[row]);
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) d[3 * c + r] = -0.5 * (s[3 * c + r] + s[3 * r + c]);
  }
}
void rows(Index n, const Index* row_start, const Index* diagonal, const Index* sources,
          const double* elements, double* values) {
  LOOMSTONE_WIDEST(rows)(n, row_start, diagonal, sources, elements, values);
}

template <class Lanes>
LOOMSTONE_INLINE void neglected_strains(const Tables& tables, BatchRange batches,
                                        const double* start, const double* end, double* out) {
  for (Index i = 0; i < batches.n; ++i) {
    const Batch<Lanes> batch = batch_of<Lanes>(tables, batches.first + i);
    Lanes3<Lanes> d1, d2;
    gradient_columns(batch, end, d1, d2);
    const Lanes area = batch.constant(0);
    const Moduli<Lanes> m = moduli(batch);
    double* o = out + neglected_stride * static_cast<std::size_t>(i);
    store(o, 2, area * energy_density(m, green_strain(d1, d2)));
    if (start) {
      Lanes3<Lanes> s1, s2;
      gradient_columns(batch, start, s1, s2);
      d1 = minus(d1, s1), d2 = minus(d2, s2);
    }
    const Tensor<Lanes> e = second_order_strain(d1, d2);
    store(o, 0, largest_eigenvalue(e));
    store(o, 1, area * energy_density(m, e));
  }
}
void neglected_strains(const Tables& tables, BatchRange batches, const double* start,
                       const double* end, double* out) {
  LOOMSTONE_WIDEST(neglected_strains)(tables, batches, start, end, out);
}

template <class Lanes>
LOOMSTONE_INLINE void strains(const Tables& tables, const Index* batches, Index n, const double* x,
                              double* out) {
  for (Index i = 0; i < n; ++i) {
    const Batch<Lanes> batch = batch_of<Lanes>(tables, batches[i]);
    Lanes3<Lanes> f1, f2;
    gradient_columns(batch, x, f1, f2);
    const Lanes c11 = dot(f1, f1), c22 = dot(f2, f2), c12 = dot(f1, f2);
    const Lanes e11 = 0.5 * (c11 - 1.0), e22 = 0.5 * (c22 - 1.0), e12 = 0.5 * c12;
    const Lanes a11 = batch.constant(1), a22 = batch.constant(2), a12 = batch.constant(3),
                g = batch.constant(4);
    Lanes energy = 0.5 * (a11 * e11 * e11 + a22 * e22 * e22) + a12 * e11 * e22 +
                   2.0 * g * e12 * e12;  // (2.21)
    if (const double* phase = phase_of(tables, batches[i])) {
      energy += phase_energy(phase, 0, e11) + phase_energy(phase, 1, e22) +
                2.0 * phase_energy(phase, 2, e12);
    }
    if (tables.limits) energy += limit_energy(tables, batches[i], Tensor<Lanes>{e11, e22, e12});
    energy *= batch.constant(0);
    const Lanes m = 0.5 * (c11 + c22), d = 0.5 * (c11 - c22);
    const Lanes stretch = lanes_sqrt(m + lanes_sqrt(d * d + c12 * c12));
    double* o = out + strain_stride * static_cast<std::size_t>(batches[i]);
    store(o, 0, e11), store(o, 1, e22), store(o, 2, e12), store(o, 3, energy), store(o, 4, stretch);
  }
}
void strains(const Tables& tables, const Index* batches, Index n, const double* x, double* out) {
  LOOMSTONE_WIDEST(strains)(tables, batches, n, x, out);
}

}  // namespace loomstone::membrane
