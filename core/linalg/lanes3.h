// Access to eight rows (3-vectors) at once, in single or double precision. A Lanes3 contains the
// three components of eight rows, with one row in each lane. gather_rows() and for_each_row()
// convert it from and to rows of four numbers, the fourth of which is zero. Each component of a
// Lanes3 is a native vector or a Halves (core/base/halves.h).
#pragma once

#include <cstddef>

#include "core/base/lane_vectors.h"
#include "core/base/types.h"
#include "core/linalg/quad.h"

namespace loomstone {

// Vector of eight numbers of type Scalar in a kernel that is compiled for the vector type Lanes.
// For doubles, Lanes256 replaces Lanes128, because each half of a Lanes256 holds the four numbers
// of a row.
template <class Lanes, class Scalar>
using LanesOf =
    std::conditional_t<std::is_same_v<Scalar, float>, FloatLanes<Lanes>,
                       std::conditional_t<std::is_same_v<Lanes, Lanes128>, Lanes256, Lanes>>;

// These functions load and store eight rows as eight x, eight y and eight z components.
template <class Vector, class Scalar>
LOOMSTONE_INLINE Lanes3<Vector> load_rows(const Scalar* p) {
  return {lanes_load<Vector>(p), lanes_load<Vector>(p + 8), lanes_load<Vector>(p + 16)};
}
template <class Vector, class Scalar>
LOOMSTONE_INLINE void store_rows(Scalar* p, const Lanes3<Vector>& a) {
  lanes_store(p, a.x), lanes_store(p + 8, a.y), lanes_store(p + 16, a.z);
}

// Builds each half of the result from four lanes of the same half of a and b. Both halves use the
// same indices: 0 to 3 denote lanes of a's half, 4 to 7 lanes of b's half.
template <int... index, class Vector>
LOOMSTONE_INLINE Vector shuffle_halves(const Vector& a, const Vector& b) {
  if constexpr (in_halves<Vector>)
    return {__builtin_shufflevector(a.low, b.low, index...),
            __builtin_shufflevector(a.high, b.high, index...)};
  else
    return __builtin_shufflevector(a, b, (index < 4 ? index : index + 4)...,
                                   (index < 4 ? index + 4 : index + 8)...);
}

template <class Vector, class Row>
LOOMSTONE_INLINE Vector side_by_side(const Row& low, const Row& high) {
  if constexpr (in_halves<Vector>)
    return {low, high};
  else
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}
template <class Vector>
LOOMSTONE_INLINE auto low_half(const Vector& a) {
  if constexpr (in_halves<Vector>)
    return a.low;
  else
    return __builtin_shufflevector(a, a, 0, 1, 2, 3);
}
template <class Vector>
LOOMSTONE_INLINE auto high_half(const Vector& a) {
  if constexpr (in_halves<Vector>)
    return a.high;
  else
    return __builtin_shufflevector(a, a, 4, 5, 6, 7);
}

// Gathers the eight rows of v with the indices `rows`. v has four numbers per row.
template <class Vector, class Scalar>
LOOMSTONE_INLINE Lanes3<Vector> gather_rows(const Index* rows, const Scalar* v) {
  Vector pair[4];  // rows l and l + 4 side by side
  for (int l = 0; l < 4; ++l)
    pair[l] = side_by_side<Vector>(quad_load(v + 4 * static_cast<std::size_t>(rows[l])),
                                   quad_load(v + 4 * static_cast<std::size_t>(rows[l + 4])));
  const Vector low02 = shuffle_halves<0, 4, 1, 5>(pair[0], pair[2]);
  const Vector low13 = shuffle_halves<0, 4, 1, 5>(pair[1], pair[3]);
  const Vector high02 = shuffle_halves<2, 6, 3, 7>(pair[0], pair[2]);
  const Vector high13 = shuffle_halves<2, 6, 3, 7>(pair[1], pair[3]);
  return {shuffle_halves<0, 4, 1, 5>(low02, low13), shuffle_halves<2, 6, 3, 7>(low02, low13),
          shuffle_halves<0, 4, 1, 5>(high02, high13)};
}

// Calls use(l, row) for the eight rows of a, in the order l = 0, 4, 1, 5, 2, 6, 3, 7. `row` is a
// vector of four numbers, the fourth of which is zero.
template <class Vector, class Use>
LOOMSTONE_INLINE void for_each_row(const Lanes3<Vector>& a, const Use& use) {
  const Vector zero{};
  const Vector low = shuffle_halves<0, 4, 1, 5>(a.x, a.y);
  const Vector high = shuffle_halves<2, 6, 3, 7>(a.x, a.y);
  const Vector low_z = shuffle_halves<0, 4, 1, 5>(a.z, zero);
  const Vector high_z = shuffle_halves<2, 6, 3, 7>(a.z, zero);
  const Vector pairs[4] = {
      // rows l and l + 4 side by side
      shuffle_halves<0, 1, 4, 5>(low, low_z), shuffle_halves<2, 3, 6, 7>(low, low_z),
      shuffle_halves<0, 1, 4, 5>(high, high_z), shuffle_halves<2, 3, 6, 7>(high, high_z)};
  for (int l = 0; l < 4; ++l) {
    use(l, low_half(pairs[l]));
    use(l + 4, high_half(pairs[l]));
  }
}

// Converts eight numbers to double precision. If the result consists of Halves, each half is
// converted separately, because gcc 12 would otherwise keep the caller's sum, a vector of eight
// doubles, in memory.
template <class Wide, class Vector>
LOOMSTONE_INLINE Wide in_doubles(const Vector& a) {
  if constexpr (in_halves<Wide>)
    return {__builtin_convertvector(low_half(a), HalfLanes),
            __builtin_convertvector(high_half(a), HalfLanes)};
  else
    return __builtin_convertvector(a, Wide);
}

}  // namespace loomstone
