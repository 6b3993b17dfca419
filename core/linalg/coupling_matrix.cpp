#include "core/linalg/coupling_matrix.h"

#include <limits>

#include "core/linalg/lanes3.h"

namespace loomstone {

namespace {

constexpr std::size_t block_stride = 72;  // numbers in eight 3x3 blocks
constexpr double no_block[9] = {};

template <class Scalar, class Lanes>
LOOMSTONE_INLINE void store_as(Scalar* out, const Lanes& a) {
  if constexpr (in_halves<Lanes>) {
    store_as(out, a.low), store_as(out + Lanes::size, a.high);
  } else {
    typedef Scalar Stored
        __attribute__((vector_size(sizeof(Lanes) / sizeof(double) * sizeof(Scalar))));
    const Stored r = __builtin_convertvector(a, Stored);
    __builtin_memcpy(out, &r, sizeof r);
  }
}

// Copies n slots (sliced_ellpack.h) of eight blocks each from `matrix` to `values`. `sources`
// contains the index of each block in `matrix`, or -1 for a zero block. Adds the blocks of each
// lane to `sums`, which has one vector for each of the 9 entries of a block.
template <class Scalar, class Lanes>
LOOMSTONE_INLINE void copy_slots(Index n, const Index* sources, const double* matrix,
                                 Scalar* values, Lanes sums[9]) {
  for (Index k = 0; k < n; ++k) {
    const double* block[8];
    for (int l = 0; l < 8; ++l)
      block[l] = sources[8 * k + l] < 0 ? no_block
                                        : matrix + 9 * static_cast<std::size_t>(sources[8 * k + l]);
    for (int e = 0; e < 9; ++e) {
      const Lanes v = lanes_of<Lanes>([&](int l) LOOMSTONE_INLINE_LAMBDA { return block[l][e]; });
      sums[e] += v;
      store_as(values + block_stride * k + 8 * e, v);
    }
  }
}

// Returns a mask of the lanes whose row sum R is a multiple of the identity, up to rounding to
// Scalar. If R is a lumped mass, it has this property.
template <class Scalar, class Lanes>
LOOMSTONE_INLINE MaskOf<Lanes> scalar_lanes(const Lanes r[9]) {
  const Lanes rounding = 0.5 * std::numeric_limits<Scalar>::epsilon() * lanes_max(r[0], -r[0]);
  MaskOf<Lanes> scalar = rounding >= 0.0;
  for (int e = 1; e < 9; ++e) {
    const Lanes other = e % 4 == 0 ? r[e] - r[0] : r[e];
    scalar &= lanes_max(other, -other) <= rounding;
  }
  return scalar;
}

// Copies the off-diagonal blocks of a slice to `values`. The sum R of each row is its diagonal
// block in `sums` plus its off-diagonal blocks. If the R of a row is a multiple of the identity up
// to rounding to Scalar, it is replaced by an exact multiple, independently of the other rows. If
// all eight R are such multiples, writes only their factors to `out` and returns true. Otherwise
// writes all entries of the eight R to `out` and returns false.
template <class Lanes, class Scalar>
LOOMSTONE_INLINE bool copy_slice(Index n, const Index* sources, const double* matrix,
                                 const double* sums, Scalar* values, Scalar* out) {
  Lanes r[9];
  for (int e = 0; e < 9; ++e) r[e] = lanes_load<Lanes>(sums + 8 * e);
  copy_slots(n, sources, matrix, values, r);
  const MaskOf<Lanes> scalar = scalar_lanes<Scalar>(r);
  if (!lanes_any(~scalar)) {
    store_as(out, r[0]);
    return true;
  }
  for (int e = 0; e < 9; ++e)
    store_as(out + 8 * e, lanes_select(scalar, e % 4 == 0 ? r[0] : Lanes{}, r[e]));
  return false;
}

template <class Vector, class Scalar>
LOOMSTONE_INLINE Lanes3<Vector> block_times(const Scalar* a, const Lanes3<Vector>& v) {
  const auto entry = [&](int e) LOOMSTONE_INLINE_LAMBDA { return lanes_load<Vector>(a + 8 * e); };
  return {(entry(0) * v.x + entry(3) * v.y) + entry(6) * v.z,
          (entry(1) * v.x + entry(4) * v.y) + entry(7) * v.z,
          (entry(2) * v.x + entry(5) * v.y) + entry(8) * v.z};
}

struct Pattern {
  const Index *rows, *slot_start, *columns;
  const std::uint8_t* scalar_sum;
};

template <class Scalar>
struct Arrays {
  const Scalar *values, *sums, *x;
};

// Returns slice g of the product A x. `here` contains x in the rows of this slice.
template <class Vector, class Scalar>
LOOMSTONE_INLINE Lanes3<Vector> couple(const Pattern& pattern, const Arrays<Scalar>& a,
                                       std::size_t g, const Lanes3<Vector>& here) {
  Lanes3<Vector> sum;
  if (pattern.scalar_sum[g]) {
    const Vector r = lanes_load<Vector>(a.sums + block_stride * g);
    sum = {r * here.x, r * here.y, r * here.z};
  } else {
    sum = block_times(a.sums + block_stride * g, here);
  }
  for (std::size_t k = pattern.slot_start[g];
       k < static_cast<std::size_t>(pattern.slot_start[g + 1]); ++k) {
    const Lanes3<Vector> there = gather_rows<Vector>(pattern.columns + 8 * k, a.x);
    const Lanes3<Vector> f = block_times(a.values + block_stride * k, minus(there, here));
    sum.x += f.x, sum.y += f.y, sum.z += f.z;
  }
  return sum;
}

template <class Lanes, class Scalar>
LOOMSTONE_INLINE double multiply_slices(Pattern pattern, Arrays<Scalar> a, Index first, Index last,
                                        Scalar* y) {
  using Vector = LanesOf<Lanes, Scalar>;
  Lanes256 product{};
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g) {
    const Lanes3<Vector> here = gather_rows<Vector>(pattern.rows + 8 * g, a.x);
    const Lanes3<Vector> sum = couple(pattern, a, g, here);
    store_rows(y + 24 * g, sum);
    product += in_doubles<Lanes256>(dot(here, sum));
  }
  return lanes_sum(product);
}

template <class Lanes, class Scalar>
LOOMSTONE_INLINE void multiply_rows(Pattern pattern, Arrays<Scalar> a, Index first, Index last,
                                    Scalar* y) {
  using Vector = LanesOf<Lanes, Scalar>;
  for (std::size_t g = first; g < static_cast<std::size_t>(last); ++g) {
    const Index* rows = pattern.rows + 8 * g;
    for_each_row(couple(pattern, a, g, gather_rows<Vector>(rows, a.x)),
                 [&](int l, const auto& row) LOOMSTONE_INLINE_LAMBDA {
                   quad_store(y + 4 * static_cast<std::size_t>(rows[l]), row);
                 });
  }
}

}  // namespace

template <class Scalar>
void CouplingMatrix<Scalar>::resize(const SlicedEllpack& slices) {
  values_.resize(block_stride * static_cast<std::size_t>(slices.slot_start.back()));
  sums_.resize(block_stride * static_cast<std::size_t>(slices.n_slices()));
  scalar_sum_.resize(slices.n_slices());
}

template <class Scalar>
void CouplingMatrix<Scalar>::set_slices(const BlockMatrix* matrix,
                                        const std::vector<Mat3>* body_blocks,
                                        const SlicedEllpack& slices, Index first, Index last) {
  const Index n_coupled = matrix ? matrix->n_rows() : 0;
  alignas(64) double sums[block_stride];
  for (Index slice = first; slice < last; ++slice) {
    for (int l = 0; l < 8; ++l) {
      const Index row = slices.rows[8 * static_cast<std::size_t>(slice) + l];
      const double* diagonal = row < n_coupled         ? matrix->block(matrix->diagonal()[row])
                               : row < slices.n_rows() ? (*body_blocks)[row - n_coupled].data()
                                                       : no_block;
      for (int e = 0; e < 9; ++e) sums[8 * e + l] = diagonal[e];
    }
    const std::size_t slot = slices.slot_start[slice];
    scalar_sum_[slice] = LOOMSTONE_WIDEST(copy_slice)(
        slices.slot_start[slice + 1] - slices.slot_start[slice], slices.sources.data() + 8 * slot,
        n_coupled > 0 ? matrix->block(0) : no_block, sums, values_.data() + block_stride * slot,
        sums_.data() + block_stride * static_cast<std::size_t>(slice));
  }
}

template <class Scalar>
double CouplingMatrix<Scalar>::multiply(const SlicedEllpack& slices, Index first, Index last,
                                        const Scalar* x, Scalar* y) const {
  const Pattern pattern{slices.rows.data(), slices.slot_start.data(), slices.columns.data(),
                        scalar_sum_.data()};
  const Arrays<Scalar> arrays{values_.data(), sums_.data(), x};
  return LOOMSTONE_WIDEST(multiply_slices)(pattern, arrays, first, last, y);
}

template <class Scalar>
void CouplingMatrix<Scalar>::multiply_to_rows(const SlicedEllpack& slices, Index first, Index last,
                                              const Scalar* x, Scalar* y) const
  requires std::is_same_v<Scalar, float>
{
  const Pattern pattern{slices.rows.data(), slices.slot_start.data(), slices.columns.data(),
                        scalar_sum_.data()};
  const Arrays<Scalar> arrays{values_.data(), sums_.data(), x};
  LOOMSTONE_WIDEST(multiply_rows)(pattern, arrays, first, last, y);
}

template class CouplingMatrix<float>;
template class CouplingMatrix<double>;

}  // namespace loomstone
