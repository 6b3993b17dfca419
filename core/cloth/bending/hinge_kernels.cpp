#include "core/cloth/bending/hinge_kernels.h"

#include "core/base/lane_vectors.h"

namespace loomstone {

namespace {

template <class Lanes>
LOOMSTONE_INLINE Lanes3<Lanes> scaled(const Lanes3<Lanes>& a, const Lanes& s) {
  return {a.x * s, a.y * s, a.z * s};
}
typedef double Lanes4 __attribute__((vector_size(32)));
LOOMSTONE_INLINE Lanes4 load4(const double* p) {
  Lanes4 r;
  __builtin_memcpy(&r, p, sizeof(Lanes4));
  return r;
}
LOOMSTONE_INLINE void store4(double* out, const Lanes4& a) {
  __builtin_memcpy(out, &a, sizeof(Lanes4));
}
template <class Lanes>
LOOMSTONE_INLINE void store(double* out, int k, const Lanes& value) {
  lanes_store(out + n_lanes * k, value);
}
// Stores component k of lane l in out[16 l + k], and zero as the fourth component. The
// transposition is done in registers, because reloading individually stored lanes is slow.
template <class Lanes>
LOOMSTONE_INLINE void store_transposed(double* out, const Lanes3<Lanes>& a) {
  const Lanes zero{};
  const Lanes even = lanes_shuffle<0, 8, 2, 10, 4, 12, 6, 14>(a.x, a.y);
  const Lanes odd = lanes_shuffle<1, 9, 3, 11, 5, 13, 7, 15>(a.x, a.y);
  const Lanes even_z = lanes_shuffle<0, 8, 2, 10, 4, 12, 6, 14>(a.z, zero);
  const Lanes odd_z = lanes_shuffle<1, 9, 3, 11, 5, 13, 7, 15>(a.z, zero);
  store4(out, lanes_shuffle<0, 1, 8, 9>(even, even_z));
  store4(out + 16, lanes_shuffle<0, 1, 8, 9>(odd, odd_z));
  store4(out + 32, lanes_shuffle<2, 3, 10, 11>(even, even_z));
  store4(out + 48, lanes_shuffle<2, 3, 10, 11>(odd, odd_z));
  store4(out + 64, lanes_shuffle<4, 5, 12, 13>(even, even_z));
  store4(out + 80, lanes_shuffle<4, 5, 12, 13>(odd, odd_z));
  store4(out + 96, lanes_shuffle<6, 7, 14, 15>(even, even_z));
  store4(out + 112, lanes_shuffle<6, 7, 14, 15>(odd, odd_z));
}

// Computes theta = atan2(s, c), and the sine and cosine of theta / 2. The angle theta is halved
// three times. The arc tangent of t = tan(theta / 8) is then t times a polynomial in t^2, where t^2
// is at most tan(pi / 8)^2. The polynomial interpolates at Chebyshev points, with a relative error
// of 7e-18. The result is accurate to a few units in the last place. It is bitwise identical on
// every machine, because no library functions or fused operations are used.
template <class Lanes>
LOOMSTONE_INLINE Lanes arc_tangent(const Lanes& s, const Lanes& c, Lanes& half_sine,
                                   Lanes& half_cosine) {
  constexpr double a[11] = {-0.3333333333333333,  0.1999999999999552,   -0.14285714284666534,
                            0.11111111015255669,  -0.09090904578095735, 0.07692183190171728,
                            -0.06664511438164644, 0.05858148832731273,  -0.05085449318930035,
                            0.039231646190551486, -0.019176872294336067};
  const Lanes zero = s - s;
  const Lanes r = lanes_sqrt(s * s + c * c);
  const Lanes sign = lanes_select(s < zero, zero - 1.0, zero + 1.0);
  // Chooses the form of tan(theta / 2) that avoids cancellation.
  const Lanes s1 = lanes_select(c < zero, sign * (r - c), s),
              c1 = lanes_select(c < zero, sign * s, r + c);
  const Lanes r1 = lanes_sqrt(s1 * s1 + c1 * c1);
  const Lanes inverse = 1.0 / lanes_select(r1 > zero, r1, zero + 1.0);
  half_sine = s1 * inverse;
  half_cosine = c1 * inverse;
  const Lanes c2 = 1.0 + half_cosine;
  const Lanes c3 = c2 + lanes_sqrt(half_sine * half_sine + c2 * c2);
  const Lanes t = half_sine / c3;  // tan(theta / 8)
  const Lanes z = t * t;
  Lanes p = zero + a[10];
  for (int k = 9; k >= 0; --k) p = p * z + a[k];
  return 8.0 * (t + t * (z * p));
}

}  // namespace

namespace hinge {

template <class Lanes>
LOOMSTONE_INLINE void angles(Tables tables, const Index* batches, Index n, const double* x,
                             const double* v, const Output& out) {
  for (Index i = 0; i < n; ++i) {
    const std::size_t b = static_cast<std::size_t>(batches[i]);
    const Index* corner = tables.vertices + vertex_stride * b;
    const Lanes3<Lanes> x3 = lanes_gather<Lanes>(corner + 16, x);
    const Lanes3<Lanes> a = minus(lanes_gather<Lanes>(corner, x), x3),
                        c = minus(lanes_gather<Lanes>(corner + 8, x), x3),
                        e = minus(lanes_gather<Lanes>(corner + 24, x), x3);
    const Lanes3<Lanes> n1 = cross(a, minus(a, e)), n2 = cross(minus(c, e), c);
    const Lanes q1 = dot(n1, n1), q2 = dot(n2, n2), ee = dot(e, e);
    const Lanes zero = ee - ee;
    // If the sine of a triangle's angle at x3 is at most 1e-12, the normal of this triangle is
    // unusable and the hinge exerts no force.
    const MaskOf<Lanes> good = (q1 > 1e-24 * ee * dot(a, a)) & (q2 > 1e-24 * ee * dot(c, c));
    const Lanes length = lanes_select(good, lanes_sqrt(ee), zero + 1.0);
    const Lanes inverse_length = 1.0 / length;
    const Lanes sine = dot(cross(n2, n1), e) * inverse_length, cosine = dot(n1, n2);
    Lanes half_sine, half_cosine;
    const Lanes angle = arc_tangent(sine, cosine, half_sine, half_cosine);
    store(out.difference + angle_stride * b, 0,
          lanes_select(good, angle - lanes_load<Lanes>(tables.rest + angle_stride * b), zero));
    store(out.half_sine + angle_stride * b, 0, half_sine);
    store(out.half_cosine + angle_stride * b, 0, half_cosine);
    if (!out.gradient) continue;
    // w = N / (|N|^2 |e|) for both triangles, with the normal N of a triangle (not of unit length)
    // and the hinge edge e.
    const Lanes3<Lanes> w1 =
        scaled(n1, lanes_select(good, inverse_length / lanes_select(good, q1, zero + 1.0), zero));
    const Lanes3<Lanes> w2 =
        scaled(n2, lanes_select(good, inverse_length / lanes_select(good, q2, zero + 1.0), zero));
    const Lanes ae = dot(a, e), ce = dot(c, e);
    const Lanes3<Lanes> u1 = scaled(w1, ee), u2 = scaled(w2, ee);
    const Lanes3<Lanes> u3 = combine(w1, ae - ee, w2, ce - ee);
    const Lanes3<Lanes> u4 = combine(w1, -ae, w2, -ce);
    double* g = out.gradient + 8 * gradient_stride * b;
    store_transposed(g, u1), store_transposed(g + 4, u2), store_transposed(g + 8, u3),
        store_transposed(g + 12, u4);
    if (!out.rate) continue;
    // The gradients sum to zero, so velocities relative to that of x3 suffice.
    const Lanes3<Lanes> v3 = lanes_gather<Lanes>(corner + 16, v);
    const Lanes rate = dot(u1, minus(lanes_gather<Lanes>(corner, v), v3)) +
                       dot(u2, minus(lanes_gather<Lanes>(corner + 8, v), v3)) +
                       dot(u4, minus(lanes_gather<Lanes>(corner + 24, v), v3));
    store(out.rate + angle_stride * b, 0, rate);
  }
}
void angles(Tables tables, const Index* batches, Index n, const double* x, const double* v,
            const Output& out) {
  LOOMSTONE_WIDEST(angles)(tables, batches, n, x, v, out);
}

template <class Lanes>
LOOMSTONE_INLINE void add_moments(HingeList list, const double* moment, const double* gradient,
                                  Index n_sums, double* sums) {
  for (Index i = 0; i < n_sums; ++i) store4(sums + 4 * i, Lanes4{});
  for (Index i = 0; i < list.n; ++i) {
    const double* u = gradient + gradient_stride * static_cast<std::size_t>(list.hinges[i]);
    const double m = moment[list.hinges[i]];
    for (int j = 0; j < 4; ++j) {
      double* sum = sums + 4 * list.places[4 * static_cast<std::size_t>(i) + j];
      store4(sum, load4(sum) + m * load4(u + 4 * j));
    }
  }
}
void add_moments(HingeList list, const double* moment, const double* gradient, Index n_sums,
                 double* sums) {
  LOOMSTONE_WIDEST(add_moments)(list, moment, gradient, n_sums, sums);
}

}  // namespace hinge

namespace midedge {

namespace {

template <class Lanes>
struct Curvature {
  Lanes xx, yy, xy;  // xy: 2 kxy
};

template <class Lanes>
LOOMSTONE_INLINE Lanes gather(const Index* hinges, const double* values) {
  return lanes_of<Lanes>([&](int l) LOOMSTONE_INLINE_LAMBDA { return values[hinges[l]]; });
}

// Returns the curvature C (difference + beta rate) of each triangle of a batch [1/m]. `c` contains
// C, the curvature per hinge angle, and beta is the damping [s]. `difference` and `rate` are those
// of hinge::Output. If `rate` is null, it counts as 0.
template <class Lanes>
LOOMSTONE_INLINE Curvature<Lanes> curvature(const Index* hinges, const double* c, const Lanes& beta,
                                            const double* difference, const double* rate) {
  Curvature<Lanes> k{};
  for (int s = 0; s < n_slots; ++s) {
    Lanes angle = gather<Lanes>(hinges + 8 * s, difference);
    if (rate) angle += beta * gather<Lanes>(hinges + 8 * s, rate);
    k.xx += lanes_load<Lanes>(c + 24 * s) * angle;
    k.yy += lanes_load<Lanes>(c + 24 * s + 8) * angle;
    k.xy += lanes_load<Lanes>(c + 24 * s + 16) * angle;
  }
  return k;
}

template <class Lanes>
LOOMSTONE_INLINE Curvature<Lanes> times(const double* w, const Curvature<Lanes>& k) {
  const Lanes w01 = lanes_load<Lanes>(w + 8), w02 = lanes_load<Lanes>(w + 16),
              w12 = lanes_load<Lanes>(w + 32);
  return {lanes_load<Lanes>(w) * k.xx + w01 * k.yy + w02 * k.xy,
          w01 * k.xx + lanes_load<Lanes>(w + 24) * k.yy + w12 * k.xy,
          w02 * k.xx + w12 * k.yy + lanes_load<Lanes>(w + 40) * k.xy};
}

}  // namespace

template <class Lanes>
LOOMSTONE_INLINE void moments(const Tables& tables, const Index* batches, Index n,
                              const double* difference, const double* rate, double* out) {
  for (Index i = 0; i < n; ++i) {
    const std::size_t b = static_cast<std::size_t>(batches[i]);
    const Index* hinges = tables.hinges + hinge_stride * b;
    const double* c = tables.curvature + curvature_stride * b;
    const double* w = tables.rigidity + rigidity_stride * b;
    const Curvature<Lanes> m =
        times(w, curvature<Lanes>(hinges, c, lanes_load<Lanes>(w + 48), difference, rate));
    double* o = out + hinge_stride * b;
    for (int s = 0; s < n_slots; ++s)
      store(o, s,
            lanes_load<Lanes>(c + 24 * s) * m.xx + lanes_load<Lanes>(c + 24 * s + 8) * m.yy +
                lanes_load<Lanes>(c + 24 * s + 16) * m.xy);
  }
}
void moments(const Tables& tables, const Index* batches, Index n, const double* difference,
             const double* rate, double* out) {
  LOOMSTONE_WIDEST(moments)(tables, batches, n, difference, rate, out);
}

template <class Lanes>
LOOMSTONE_INLINE void energies(const Tables& tables, const Index* batches, Index n,
                               const double* difference, double* out) {
  for (Index i = 0; i < n; ++i) {
    const std::size_t b = static_cast<std::size_t>(batches[i]);
    const double* w = tables.rigidity + rigidity_stride * b;
    const Curvature<Lanes> k =
        curvature(tables.hinges + hinge_stride * b, tables.curvature + curvature_stride * b,
                  lanes_load<Lanes>(w + 48), difference, nullptr);
    const Curvature<Lanes> m = times(w, k);
    store(out + 8 * b, 0, 0.5 * (k.xx * m.xx + k.yy * m.yy + k.xy * m.xy));
  }
}
void energies(const Tables& tables, const Index* batches, Index n, const double* difference,
              double* out) {
  LOOMSTONE_WIDEST(energies)(tables, batches, n, difference, out);
}

}  // namespace midedge

}  // namespace loomstone
