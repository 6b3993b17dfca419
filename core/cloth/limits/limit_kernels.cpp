#include "core/cloth/limits/limit_kernels.h"

#include <algorithm>
#include <cstddef>
#include <type_traits>

namespace loomstone::limit {

namespace {

// Real is double (one element) or Lanes (eight elements).
template <class Real>
LOOMSTONE_INLINE Real load(const double* p) {
  if constexpr (std::is_same_v<Real, double>)
    return *p;
  else
    return lanes_load<Real>(p);
}

template <class Real>
LOOMSTONE_INLINE Element<Real> gradients_at(const double* gradients) {
  constexpr int n = width<Real>;
  Element<Real> e{};
  e.g0x = load<Real>(gradients), e.g0y = load<Real>(gradients + n);
  e.g1x = load<Real>(gradients + 2 * n), e.g1y = load<Real>(gradients + 3 * n);
  return e;
}

template <class Real>
LOOMSTONE_INLINE Element<Real> element_at(const double* gradients, const double* numbers) {
  constexpr int n = width<Real>;
  const auto at = [&](int k)
                      LOOMSTONE_INLINE_LAMBDA -> Real { return load<Real>(numbers + n * k); };
  Element<Real> e = gradients_at<Real>(gradients);
  e.x0 = at(0), e.y0 = at(1), e.x1 = at(2), e.y1 = at(3), e.x2 = at(4), e.y2 = at(5);
  e.moments = {at(6), at(7), at(8)};
  return e;
}

LOOMSTONE_INLINE const double* gradients_of(const Tables& tables, std::size_t batch) {
  return tables.gradients + 8 * element_gradients * batch;
}

// Position or velocity of corner k of one element or of a batch of elements. `corners` is the table
// (3 x 8) of the batch; for one element, it points to the lane of the element in this table.
template <class Real>
LOOMSTONE_INLINE Space<Real> point(const Index* corners, int k, const double* x) {
  const auto component = [&](int c) LOOMSTONE_INLINE_LAMBDA -> Real {
    const auto of_lane = [&](int l) LOOMSTONE_INLINE_LAMBDA {
      return x[3 * static_cast<std::size_t>(corners[8 * k + l]) + c];
    };
    if constexpr (std::is_same_v<Real, double>)
      return of_lane(0);
    else
      return lanes_of<Real>(of_lane);
  };
  return {component(0), component(1), component(2)};
}

// Strain rate in the co-rotated frame of the element, sym(R^T dF/dt).
template <class Real>
LOOMSTONE_INLINE Symmetric<Real> rate(const Element<Real>& e, const Index* corners, const double* v,
                                      const Space<Real>& r1, const Space<Real>& r2) {
  Space<Real> d1, d2;
  columns(e, point<Real>(corners, 0, v), point<Real>(corners, 1, v), point<Real>(corners, 2, v), d1,
          d2);
  return {dot(r1, d1), dot(r2, d2), 0.5 * (dot(r1, d2) + dot(r2, d1))};
}

// Returns true if dF/dt is so small in all elements of a batch that the strain rate sym(R^T dF/dt)
// is within its bounds for every rotation R. The polar decomposition, which determines R, is then
// not needed.
template <class Lanes>
LOOMSTONE_INLINE bool slow(const Element<Lanes>& e, const Index* corners, const Bounds& bounds,
                           const double* v) {
  double least = bounds.high[0];
  for (int k = 0; k < 3; ++k) least = std::min({least, bounds.high[k], -bounds.low[k]});
  Space<Lanes> d1, d2;
  columns(e, point<Lanes>(corners, 0, v), point<Lanes>(corners, 1, v), point<Lanes>(corners, 2, v),
          d1, d2);
  return least > 0.0 &&
         // The factor 0.99 leaves a margin for rounding errors.
         largest(greater(dot(d1, d1), dot(d2, d2))) < 0.99 * least * least;
}

template <class Real>
struct Correction {
  Space<Real> g1, g2;
  Real size;  // largest magnitude of the corrected components of the excess
};

// Computes the correction of an element or a batch. Returns false if no element exceeds its bounds
// by more than the tolerance.
template <class Real>
LOOMSTONE_INLINE bool correction(const Element<Real>& e, const Index* corners,
                                 const std::uint8_t* moves, const Bounds& bounds,
                                 const Motion& motion, Correction<Real>& out) {
  const Polar<Real> polar =
      stretch(e, point<Real>(corners, 0, motion.x), point<Real>(corners, 1, motion.x),
              point<Real>(corners, 2, motion.x));
  Space<Real> r1, r2;
  Symmetric<Real> back;
  if (motion.v) {
    rotation(polar, r1, r2);
    back = excess(bounds, rate(e, corners, motion.v, r1, r2));
  } else {
    back = excess(bounds, Symmetric<Real>{polar.u.a11 - 1.0, polar.u.a22 - 1.0, polar.u.a12});
  }
  const Space<Real> beyond = {size(back.a11), size(back.a22), size(back.a12)};
  out.size = greater(beyond.x, greater(beyond.y, beyond.z));
  if (!(largest(out.size) > motion.tolerance)) return false;
  if (!motion.v) rotation(polar, r1, r2);
  Real w = spin(e.moments, polar.u, back);
  std::uint8_t any = 0;
  for (int l = 0; l < width<Real>; ++l) any |= moves[l];
  if (any & two_held) {
    const Real other = spin_of_two(e.moments, back), reach = reach_of_two(e.moments, back);
    for (int l = 0; l < width<Real>; ++l)
      if (moves[l] & two_held) put(w, l, at(other, l)), put(out.size, l, at(reach, l));
  }
  field(r1, r2, back, w, out.g1, out.g2);
  return true;
}

// Adds `delta` to the positions or velocities (`values`) of the free corners of one lane. Held
// corners are not written and stay bitwise unchanged.
template <class Real>
LOOMSTONE_INLINE void move(const Space<Real> delta[3], const Index* corners, int lane,
                           std::uint8_t moves, double* values) {
  for (int k = 0; k < 3; ++k) {
    if (!(moves >> k & 1)) continue;
    double* p = values + 3 * static_cast<std::size_t>(corners[8 * k + lane]);
    p[0] += at(delta[k].x, lane), p[1] += at(delta[k].y, lane), p[2] += at(delta[k].z, lane);
  }
}

template <class Real>
LOOMSTONE_INLINE void displacements(const Element<Real>& e, const Correction<Real>& c,
                                    Space<Real> delta[3]) {
  delta[0] = combine(c.g1, e.x0, c.g2, e.y0);
  delta[1] = combine(c.g1, e.x1, c.g2, e.y1);
  delta[2] = combine(c.g1, e.x2, c.g2, e.y2);
}

// Bit mask of the lanes with a free corner and a correction `size` above the tolerance.
template <class Lanes>
LOOMSTONE_INLINE unsigned lanes_to_correct(const Lanes& size, const std::uint8_t* moves,
                                           double tolerance) {
  unsigned bits = 0;
  for (int l = 0; l < n_lanes; ++l)
    bits |= static_cast<unsigned>(moves[l] != 0 && size[l] > tolerance) << l;
  return bits;
}

// Computes the changes of x, or of v, at the corners of a batch. Returns a bit mask of the lanes to
// correct. If the mask is 0, the contents of `delta` are undefined.
template <class Lanes>
LOOMSTONE_INLINE unsigned correct_batch(const Tables& tables, const Motion& motion, std::size_t b,
                                        Space<Lanes> delta[3]) {
  const std::uint8_t* moves = tables.moves + 8 * b;
  const Element<Lanes> e = element_at<Lanes>(
      gradients_of(tables, b), tables.numbers + 8 * (element_numbers - element_gradients) * b);
  Correction<Lanes> c;
  if (!correction(e, tables.corners + 24 * b, moves, tables.bounds[tables.bounds_of[b]], motion, c))
    return 0;
  displacements(e, c, delta);
  return lanes_to_correct(c.size, moves, motion.tolerance);
}

}  // namespace

template <class Lanes>
LOOMSTONE_INLINE void sweep(const Tables& tables, const Motion& motion, const Index* batches,
                            Index n, std::uint8_t* corrected) {
  for (Index i = 0; i < n; ++i) {
    const std::size_t b = static_cast<std::size_t>(batches[i]);
    Space<Lanes> delta[3];
    unsigned bits = correct_batch(tables, motion, b, delta);
    corrected[b] = static_cast<std::uint8_t>(bits);
    for (; bits != 0; bits &= bits - 1) {
      const int lane = __builtin_ctz(bits);
      move(delta, tables.corners + 24 * b, lane, tables.moves[8 * b + lane],
           motion.v ? motion.v : motion.x);
    }
  }
}
void sweep(const Tables& tables, const Motion& motion, const Index* batches, Index n,
           std::uint8_t* corrected) {
  LOOMSTONE_WIDEST(sweep)(tables, motion, batches, n, corrected);
}

template <class Lanes>
LOOMSTONE_INLINE void corrections(const Tables& tables, const Motion& motion, const Index* batches,
                                  Index n, std::uint8_t* corrected, double* out) {
  for (Index i = 0; i < n; ++i) {
    const std::size_t b = static_cast<std::size_t>(batches[i]);
    Space<Lanes> delta[3];
    corrected[b] = static_cast<std::uint8_t>(correct_batch(tables, motion, b, delta));
    if (corrected[b] == 0) continue;
    double* o = out + 72 * b;
    for (int k = 0; k < 3; ++k)
      lanes_store(o + 24 * k, delta[k].x), lanes_store(o + 24 * k + 8, delta[k].y),
          lanes_store(o + 24 * k + 16, delta[k].z);
  }
}
void corrections(const Tables& tables, const Motion& motion, const Index* batches, Index n,
                 std::uint8_t* corrected, double* out) {
  LOOMSTONE_WIDEST(corrections)(tables, motion, batches, n, corrected, out);
}

bool correct_one(const Tables& tables, const Motion& motion, Index slot) {
  const std::size_t b = static_cast<std::size_t>(slot / 8),
                    lane = static_cast<std::size_t>(slot % 8);
  const Index* corners = tables.corners + 24 * b + lane;
  const std::uint8_t moves = tables.moves[slot];
  const double* row = tables.rows + element_numbers * static_cast<std::size_t>(slot);
  const Element<double> e = element_at<double>(row, row + element_gradients);
  Correction<double> c;
  const bool found = correction(e, corners, &moves, tables.bounds[tables.bounds_of[b]], motion, c);
  if (!found || moves == 0 || !(c.size > motion.tolerance)) return false;
  Space<double> delta[3];
  displacements(e, c, delta);
  move(delta, corners, 0, moves, motion.v ? motion.v : motion.x);
  return true;
}

template <class Lanes>
LOOMSTONE_INLINE void check(const Tables& tables, const Motion& motion, const Index* batches,
                            Index first, Index n, Violations out) {
  for (Index i = first; i < first + n; ++i) {
    const std::size_t b = static_cast<std::size_t>(batches ? batches[i] : i);
    const Index* corners = tables.corners + 24 * b;
    const Bounds& bounds = tables.bounds[tables.bounds_of[b]];
    const Element<Lanes> e = gradients_at<Lanes>(gradients_of(tables, b));
    out.excess[b] = 0.0;
    if (motion.v && slow(e, corners, bounds, motion.v)) continue;
    const Polar<Lanes> polar =
        stretch(e, point<Lanes>(corners, 0, motion.x), point<Lanes>(corners, 1, motion.x),
                point<Lanes>(corners, 2, motion.x));
    Symmetric<Lanes> strain = {polar.u.a11 - 1.0, polar.u.a22 - 1.0, polar.u.a12};
    if (motion.v) {
      Space<Lanes> r1, r2;
      rotation(polar, r1, r2);
      strain = rate(e, corners, motion.v, r1, r2);
    }
    const Symmetric<Lanes> back = excess(bounds, strain);
    out.excess[b] = largest(greater(size(back.a11), greater(size(back.a22), size(back.a12))));
    if (out.excess[b] == 0.0) continue;
    double* o = out.strains + 24 * b;
    lanes_store(o, strain.a11), lanes_store(o + 8, strain.a22), lanes_store(o + 16, strain.a12);
  }
}
void check(const Tables& tables, const Motion& motion, const Index* batches, Index first, Index n,
           Violations out) {
  LOOMSTONE_WIDEST(check)(tables, motion, batches, first, n, out);
}

}  // namespace loomstone::limit
