#include "core/linalg/pcg_kernels.h"

#include <algorithm>

#include "core/base/lane_bits.h"
#include "core/linalg/lanes3.h"

namespace loomstone::pcg {

namespace {

LOOMSTONE_INLINE Quad widened(const FloatQuad& a) { return __builtin_convertvector(a, Quad); }
LOOMSTONE_INLINE Quad widened(const Quad& a) { return a; }

template <class Lanes, class Scalar>
LOOMSTONE_INLINE void sum_rows(Index first, Index last, const Index* slots, const Scalar* v,
                               Scalar* sums) {
  using Vector = LanesOf<Lanes, Scalar>;
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g)
    for_each_row(load_rows<Vector>(v + 24 * g), [&](int l, auto row) LOOMSTONE_INLINE_LAMBDA {
      Scalar* sum = sums + 4 * static_cast<std::size_t>(slots[8 * g + l]);
      quad_store(sum, quad_load(sum) + row);
    });
}

// Updates one row of p and x; see update_direction(). p and x point to this row.
template <class Scalar, class Row>
LOOMSTONE_INLINE void update_row(double length, Scalar beta, const Row& z, Scalar* p, double* x) {
  const Row old = quad_load(p);
  quad_store(x, quad_load(x) + length * widened(old));
  quad_store(p, z + beta * old);
}

template <class Lanes, class Scalar>
LOOMSTONE_INLINE void directions(SliceRows on, DirectionFactors<Scalar> factors,
                                 PreconditionedResidual<Scalar> residual, Scalar* p, double* x) {
  using Vector = LanesOf<Lanes, Scalar>;
  for (std::size_t g = on.first; g < static_cast<std::size_t>(on.last); ++g)
    for_each_row(load_rows<Vector>(residual.z + 24 * g), [&](int l,
                                                             auto row) LOOMSTONE_INLINE_LAMBDA {
      const std::size_t place = 8 * g + l;
      if (residual.correction) {
        const FloatQuad more =
            quad_load(residual.correction + 4 * static_cast<std::size_t>(on.slots[place]));
        row += __builtin_convertvector(more, decltype(row));
      }
      const std::size_t of_p = on.rows[place], of_x = std::min(on.rows[place], on.end) - on.begin;
      update_row(factors.length, factors.beta, row, p + 4 * of_p, x + 4 * of_x);
    });
}

template <class Vector>
struct Inverse {
  Vector xx, xy, xz, yy, yz, zz;
  LOOMSTONE_INLINE Lanes3<Vector> times(const Lanes3<Vector>& r) const {
    return {(xx * r.x + xy * r.y) + xz * r.z, (xy * r.x + yy * r.y) + yz * r.z,
            (xz * r.x + yz * r.y) + zz * r.z};
  }
};

template <class Vector, class Scalar>
LOOMSTONE_INLINE Inverse<Vector> load_inverse(const Scalar* m) {
  return {lanes_load<Vector>(m),      lanes_load<Vector>(m + 8),  lanes_load<Vector>(m + 16),
          lanes_load<Vector>(m + 24), lanes_load<Vector>(m + 32), lanes_load<Vector>(m + 40)};
}

template <class Lanes, class Scalar>
LOOMSTONE_INLINE double preconditioned(Index first, Index last, const Scalar* inverse,
                                       const Scalar* r, Scalar* z) {
  using Vector = LanesOf<Lanes, Scalar>;
  Lanes256 sum{};
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g) {
    const Lanes3<Vector> residual = load_rows<Vector>(r + 24 * g),
                         out = load_inverse<Vector>(inverse + 48 * g).times(residual);
    store_rows(z + 24 * g, out);
    sum += in_doubles<Lanes256>(dot(residual, out));
  }
  return lanes_sum(sum);
}

template <class Lanes>
LOOMSTONE_INLINE double wide_square(Index first, Index last, const float* inverse,
                                    const double* r) {
  using Wide = LanesOf<Lanes, double>;
  Wide sum{};
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g) {
    const auto entry = [&](int e) LOOMSTONE_INLINE_LAMBDA {
      return in_doubles<Wide>(lanes_load<FloatLanes<Lanes>>(inverse + 48 * g + 8 * e));
    };
    const Inverse<Wide> m = {entry(0), entry(1), entry(2), entry(3), entry(4), entry(5)};
    const Lanes3<Wide> residual = load_rows<Wide>(r + 24 * g);
    sum += dot(residual, m.times(residual));
  }
  return lanes_sum(sum);
}

template <class Lanes, class Scalar>
LOOMSTONE_INLINE double step(Index first, Index last, Scalar alpha, const Scalar* q,
                             const Scalar* inverse, Residuals<Scalar> out) {
  using Vector = LanesOf<Lanes, Scalar>;
  Lanes256 sum{};
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g) {
    Lanes3<Vector> residual = load_rows<Vector>(out.r + 24 * g);
    const Lanes3<Vector> change = load_rows<Vector>(q + 24 * g);
    residual.x -= alpha * change.x, residual.y -= alpha * change.y, residual.z -= alpha * change.z;
    store_rows(out.r + 24 * g, residual);
    const Lanes3<Vector> z = load_inverse<Vector>(inverse + 48 * g).times(residual);
    store_rows(out.z + 24 * g, z);
    sum += in_doubles<Lanes256>(dot(residual, z));
  }
  return lanes_sum(sum);
}

template <class, class Scalar>
LOOMSTONE_INLINE void moved(Index n, double length, const Scalar* p, double* x) {
  for (std::size_t i = 0; i < 4 * static_cast<std::size_t>(n); ++i)
    x[i] += length * static_cast<double>(p[i]);
}

// Inverts eight blocks by the same closed form as invert_positive_definite(). Returns a bit mask of
// the blocks that are not positive definite: those with a leading minor that is not positive.
template <class Lanes>
LOOMSTONE_INLINE unsigned inverted(double* blocks) {
  const Inverse<Lanes> a = load_inverse<Lanes>(blocks);
  const Lanes c00 = a.yy * a.zz - a.yz * a.yz, c01 = a.xz * a.yz - a.xy * a.zz,
              c02 = a.xy * a.yz - a.xz * a.yy;
  const Lanes minor2 = a.xx * a.yy - a.xy * a.xy;
  const Lanes determinant = a.xx * c00 + a.xy * c01 + a.xz * c02;
  const unsigned definite = lanes_bits((a.xx > 0.0) & (minor2 > 0.0) & (determinant > 0.0));
  const Lanes scale = 1.0 / determinant;
  const Lanes inverse[6] = {scale * c00,
                            scale * c01,
                            scale * c02,
                            scale * (a.xx * a.zz - a.xz * a.xz),
                            scale * (a.xy * a.xz - a.xx * a.yz),
                            scale * minor2};
  for (int e = 0; e < 6; ++e) lanes_store(blocks + 8 * e, inverse[e]);
  return ~definite & 0xffu;
}

}  // namespace

unsigned invert(double* blocks) { return LOOMSTONE_WIDEST(inverted)(blocks); }

void add_up(Index first, Index last, const Index* slots, const float* v, float* sums) {
  LOOMSTONE_WIDEST(sum_rows)(first, last, slots, v, sums);
}
void add_up(Index first, Index last, const Index* slots, const double* v, double* sums) {
  LOOMSTONE_WIDEST(sum_rows)(first, last, slots, v, sums);
}

void update_direction(SliceRows on, DirectionFactors<float> factors,
                      PreconditionedResidual<float> residual, float* p, double* x) {
  LOOMSTONE_WIDEST(directions)(on, factors, residual, p, x);
}
void update_direction(SliceRows on, DirectionFactors<double> factors,
                      PreconditionedResidual<double> residual, double* p, double* x) {
  LOOMSTONE_WIDEST(directions)(on, factors, residual, p, x);
}

double precondition(Index first, Index last, const float* inverse, const float* r, float* z) {
  return LOOMSTONE_WIDEST(preconditioned)(first, last, inverse, r, z);
}
double precondition(Index first, Index last, const double* inverse, const double* r, double* z) {
  return LOOMSTONE_WIDEST(preconditioned)(first, last, inverse, r, z);
}

double preconditioned_square(Index first, Index last, const float* inverse, const double* r) {
  return LOOMSTONE_WIDEST(wide_square)(first, last, inverse, r);
}

double take_step(Index first, Index last, float alpha, const float* q, const float* inverse,
                 Residuals<float> out) {
  return LOOMSTONE_WIDEST(step)(first, last, alpha, q, inverse, out);
}
double take_step(Index first, Index last, double alpha, const double* q, const double* inverse,
                 Residuals<double> out) {
  return LOOMSTONE_WIDEST(step)(first, last, alpha, q, inverse, out);
}

void move(Index n, double length, const float* p, double* x) {
  LOOMSTONE_WIDEST(moved)(n, length, p, x);
}
void move(Index n, double length, const double* p, double* x) {
  LOOMSTONE_WIDEST(moved)(n, length, p, x);
}

}  // namespace loomstone::pcg
