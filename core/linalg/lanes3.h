// Arithmetic on eight rows at once, in single or double precision. A Triple contains three
// components of eight rows, with one row in each lane. It is converted from and to rows of four
// numbers, the fourth of which is zero.
#pragma once

#include <cstddef>

#include "core/base/types.h"
#include "core/linalg/quad.h"

namespace loomstone {

template <class Scalar>
struct LaneTypes;
template <>
struct LaneTypes<float> {
  typedef float Lane __attribute__((vector_size(32)));
  using Row = FloatQuad;
};
template <>
struct LaneTypes<double> {
  using Lane = Lanes;
  using Row = Quad;
};
template <class Scalar>
using LanesOf = typename LaneTypes<Scalar>::Lane;

template <class Scalar>
struct Triple {
  LanesOf<Scalar> x, y, z;
};

template <class Scalar>
LOOMSTONE_INLINE LanesOf<Scalar> load_lanes(const Scalar* p) {
  LanesOf<Scalar> r;
  __builtin_memcpy(&r, p, sizeof r);
  return r;
}

// Load and store a triple in the order of eight x, eight y and eight z.
template <class Scalar>
LOOMSTONE_INLINE Triple<Scalar> load_triple(const Scalar* p) {
  return {load_lanes(p), load_lanes(p + 8), load_lanes(p + 16)};
}
template <class Scalar>
LOOMSTONE_INLINE void store_triple(Scalar* p, const Triple<Scalar>& a) {
  __builtin_memcpy(p, &a.x, sizeof a.x);
  __builtin_memcpy(p + 8, &a.y, sizeof a.y);
  __builtin_memcpy(p + 16, &a.z, sizeof a.z);
}

// Gathers eight rows of v, which has four numbers per row.
template <class Scalar>
LOOMSTONE_INLINE Triple<Scalar> gather_rows(const Index* rows, const Scalar* v) {
  using Lane = LanesOf<Scalar>;
  Lane pair[4];  // rows l and l + 4 side by side
  for (int l = 0; l < 4; ++l)
    pair[l] = __builtin_shufflevector(quad_load(v + 4 * static_cast<std::size_t>(rows[l])),
                                      quad_load(v + 4 * static_cast<std::size_t>(rows[l + 4])), 0,
                                      1, 2, 3, 4, 5, 6, 7);
  const Lane low02 = __builtin_shufflevector(pair[0], pair[2], 0, 8, 1, 9, 4, 12, 5, 13);
  const Lane low13 = __builtin_shufflevector(pair[1], pair[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const Lane high02 = __builtin_shufflevector(pair[0], pair[2], 2, 10, 3, 11, 6, 14, 7, 15);
  const Lane high13 = __builtin_shufflevector(pair[1], pair[3], 2, 10, 3, 11, 6, 14, 7, 15);
  return {__builtin_shufflevector(low02, low13, 0, 8, 1, 9, 4, 12, 5, 13),
          __builtin_shufflevector(low02, low13, 2, 10, 3, 11, 6, 14, 7, 15),
          __builtin_shufflevector(high02, high13, 0, 8, 1, 9, 4, 12, 5, 13)};
}

// Converts a triple to rows. pairs[l] contains rows l and l + 4 side by side, for l = 0 to 3.
template <class Scalar>
LOOMSTONE_INLINE void to_row_pairs(const Triple<Scalar>& a, LanesOf<Scalar> pairs[4]) {
  using Lane = LanesOf<Scalar>;
  const Lane zero{};
  const Lane low = __builtin_shufflevector(a.x, a.y, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lane high = __builtin_shufflevector(a.x, a.y, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lane low_z = __builtin_shufflevector(a.z, zero, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lane high_z = __builtin_shufflevector(a.z, zero, 2, 10, 3, 11, 6, 14, 7, 15);
  pairs[0] = __builtin_shufflevector(low, low_z, 0, 1, 8, 9, 4, 5, 12, 13);
  pairs[1] = __builtin_shufflevector(low, low_z, 2, 3, 10, 11, 6, 7, 14, 15);
  pairs[2] = __builtin_shufflevector(high, high_z, 0, 1, 8, 9, 4, 5, 12, 13);
  pairs[3] = __builtin_shufflevector(high, high_z, 2, 3, 10, 11, 6, 7, 14, 15);
}

template <class Scalar>
LOOMSTONE_INLINE LanesOf<Scalar> dot(const Triple<Scalar>& a, const Triple<Scalar>& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

// Converts to double precision in two halves. With registers of four doubles, gcc 12 would keep a
// sum of eight doubles in memory.
template <class Lane>
LOOMSTONE_INLINE Lanes256 in_doubles(const Lane& a) {
  return {__builtin_convertvector(__builtin_shufflevector(a, a, 0, 1, 2, 3), HalfLanes),
          __builtin_convertvector(__builtin_shufflevector(a, a, 4, 5, 6, 7), HalfLanes)};
}

}  // namespace loomstone
