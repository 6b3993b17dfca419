#include "core/linalg/pcg_kernels.h"

#include "core/linalg/lanes3.h"

namespace loomstone::pcg {

namespace {

LOOMSTONE_INLINE Quad widened(const FloatQuad& a) { return __builtin_convertvector(a, Quad); }
LOOMSTONE_INLINE Quad widened(const Quad& a) { return a; }
LOOMSTONE_INLINE FloatQuad narrowed(const FloatQuad& a) { return a; }
LOOMSTONE_INLINE FloatQuad narrowed(const Quad& a) { return __builtin_convertvector(a, FloatQuad); }

template <class Scalar>
LOOMSTONE_INLINE void sum_rows(Index first, Index last, const Index* slots, const Scalar* r,
                               float* sums) {
  const auto add = [&](Index slot, const auto& row) LOOMSTONE_INLINE_LAMBDA {
    float* sum = sums + 4 * static_cast<std::size_t>(slot);
    quad_store(sum, quad_load(sum) + narrowed(row));
  };
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g) {
    LanesOf<Scalar> pairs[4];
    to_row_pairs(load_triple(r + 24 * g), pairs);
    for (int l = 0; l < 4; ++l) {
      add(slots[8 * g + l], __builtin_shufflevector(pairs[l], pairs[l], 0, 1, 2, 3));
      add(slots[8 * g + l + 4], __builtin_shufflevector(pairs[l], pairs[l], 4, 5, 6, 7));
    }
  }
}

template <class Scalar, class Row>
LOOMSTONE_INLINE void update_row(Index row, double length, Scalar beta, const Row& z, Scalar* p,
                                 double* x) {
  const std::size_t i = 4 * static_cast<std::size_t>(row);
  const Row old = quad_load(p + i);
  quad_store(x + i, quad_load(x + i) + length * widened(old));
  quad_store(p + i, z + beta * old);
}

template <class Scalar>
LOOMSTONE_INLINE void directions(SliceRows on, DirectionFactors<Scalar> factors,
                                 PreconditionedResidual<Scalar> residual, Scalar* p, double* x) {
  const auto update = [&](std::size_t place, auto row) LOOMSTONE_INLINE_LAMBDA {
    if (residual.correction) {
      const FloatQuad more =
          quad_load(residual.correction + 4 * static_cast<std::size_t>(on.slots[place]));
      row += __builtin_convertvector(more, decltype(row));
    }
    update_row(on.rows[place], factors.length, factors.beta, row, p, x);
  };
  for (std::size_t g = on.first; g < static_cast<std::size_t>(on.last); ++g) {
    LanesOf<Scalar> pairs[4];
    to_row_pairs(load_triple(residual.z + 24 * g), pairs);
    for (int l = 0; l < 4; ++l) {
      update(8 * g + l, __builtin_shufflevector(pairs[l], pairs[l], 0, 1, 2, 3));
      update(8 * g + l + 4, __builtin_shufflevector(pairs[l], pairs[l], 4, 5, 6, 7));
    }
  }
}

template <class Scalar>
struct Inverse {
  LanesOf<Scalar> xx, xy, xz, yy, yz, zz;
  LOOMSTONE_INLINE Triple<Scalar> times(const Triple<Scalar>& r) const {
    return {(xx * r.x + xy * r.y) + xz * r.z, (xy * r.x + yy * r.y) + yz * r.z,
            (xz * r.x + yz * r.y) + zz * r.z};
  }
};

template <class Scalar>
LOOMSTONE_INLINE Inverse<Scalar> load_inverse(const Scalar* m) {
  return {load_lanes(m),      load_lanes(m + 8),  load_lanes(m + 16),
          load_lanes(m + 24), load_lanes(m + 32), load_lanes(m + 40)};
}

template <class Scalar>
LOOMSTONE_INLINE double preconditioned(Index first, Index last, const Scalar* inverse,
                                       const Scalar* r, Scalar* z) {
  Lanes256 sum{};
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g) {
    const Triple<Scalar> residual = load_triple(r + 24 * g),
                         out = load_inverse(inverse + 48 * g).times(residual);
    store_triple(z + 24 * g, out);
    sum += in_doubles(dot(residual, out));
  }
  return lanes_sum(sum);
}

template <class Scalar>
LOOMSTONE_INLINE double step(Index first, Index last, Scalar alpha, const Scalar* q,
                             const Scalar* inverse, Residuals<Scalar> out) {
  Lanes256 sum{};
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g) {
    Triple<Scalar> residual = load_triple(out.r + 24 * g);
    const Triple<Scalar> change = load_triple(q + 24 * g);
    residual.x -= alpha * change.x, residual.y -= alpha * change.y, residual.z -= alpha * change.z;
    store_triple(out.r + 24 * g, residual);
    const Triple<Scalar> z = load_inverse(inverse + 48 * g).times(residual);
    store_triple(out.z + 24 * g, z);
    sum += in_doubles(dot(residual, z));
  }
  return lanes_sum(sum);
}

}  // namespace

// Closed form, as in invert_positive_definite(). A block is positive definite if its leading minors
// are positive.
LOOMSTONE_CLONES
unsigned invert(double* blocks) {
  const Inverse<double> a = load_inverse(blocks);
  const Lanes c00 = a.yy * a.zz - a.yz * a.yz, c01 = a.xz * a.yz - a.xy * a.zz,
              c02 = a.xy * a.yz - a.xz * a.yy;
  const Lanes minor2 = a.xx * a.yy - a.xy * a.xy;
  const Lanes determinant = a.xx * c00 + a.xy * c01 + a.xz * c02;
  const Lanes definite =
      __builtin_convertvector((a.xx > 0.0) & (minor2 > 0.0) & (determinant > 0.0), Lanes);
  double lanes[8];
  lanes_store(lanes, definite);
  unsigned bad = 0;
  for (int l = 0; l < 8; ++l) bad |= (lanes[l] != 0.0 ? 0u : 1u) << l;
  const Lanes scale = 1.0 / determinant;
  const Lanes inverse[6] = {scale * c00,
                            scale * c01,
                            scale * c02,
                            scale * (a.xx * a.zz - a.xz * a.xz),
                            scale * (a.xy * a.xz - a.xx * a.yz),
                            scale * minor2};
  for (int e = 0; e < 6; ++e) lanes_store(blocks + 8 * e, inverse[e]);
  return bad;
}

LOOMSTONE_CLONES
void add_up(Index first, Index last, const Index* slots, const float* r, float* sums) {
  sum_rows(first, last, slots, r, sums);
}
LOOMSTONE_CLONES
void add_up(Index first, Index last, const Index* slots, const double* r, float* sums) {
  sum_rows(first, last, slots, r, sums);
}

LOOMSTONE_CLONES
void update_direction(SliceRows on, DirectionFactors<float> factors,
                      PreconditionedResidual<float> residual, float* p, double* x) {
  directions(on, factors, residual, p, x);
}
LOOMSTONE_CLONES
void update_direction(SliceRows on, DirectionFactors<double> factors,
                      PreconditionedResidual<double> residual, double* p, double* x) {
  directions(on, factors, residual, p, x);
}

LOOMSTONE_CLONES
double precondition(Index first, Index last, const float* inverse, const float* r, float* z) {
  return preconditioned(first, last, inverse, r, z);
}
LOOMSTONE_CLONES
double precondition(Index first, Index last, const double* inverse, const double* r, double* z) {
  return preconditioned(first, last, inverse, r, z);
}

LOOMSTONE_CLONES
double preconditioned_square(Index first, Index last, const float* inverse, const double* r) {
  Lanes sum{};
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g) {
    const Inverse<float> m = load_inverse(inverse + 48 * g);
    const Inverse<double> wide = {
        __builtin_convertvector(m.xx, Lanes), __builtin_convertvector(m.xy, Lanes),
        __builtin_convertvector(m.xz, Lanes), __builtin_convertvector(m.yy, Lanes),
        __builtin_convertvector(m.yz, Lanes), __builtin_convertvector(m.zz, Lanes)};
    const Triple<double> residual = load_triple(r + 24 * g);
    sum += dot(residual, wide.times(residual));
  }
  return lanes_sum(sum);
}

LOOMSTONE_CLONES
double take_step(Index first, Index last, float alpha, const float* q, const float* inverse,
                 Residuals<float> out) {
  return step(first, last, alpha, q, inverse, out);
}
LOOMSTONE_CLONES
double take_step(Index first, Index last, double alpha, const double* q, const double* inverse,
                 Residuals<double> out) {
  return step(first, last, alpha, q, inverse, out);
}

LOOMSTONE_CLONES
void move(Index begin, Index end, double length, const float* p, double* x) {
  for (std::size_t i = 4 * static_cast<std::size_t>(begin); i < 4 * static_cast<std::size_t>(end);
       ++i)
    x[i] += length * static_cast<double>(p[i]);
}
LOOMSTONE_CLONES
void move(Index begin, Index end, double length, const double* p, double* x) {
  for (std::size_t i = 4 * static_cast<std::size_t>(begin); i < 4 * static_cast<std::size_t>(end);
       ++i)
    x[i] += length * p[i];
}

}  // namespace loomstone::pcg
