#include "core/linalg/symmetric_gauss_seidel.h"

#include <algorithm>
#include <numeric>
#include <type_traits>

#include "core/linalg/quad.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

// Returns the cloth rows ordered by block and, within a block, by dependency level, followed by the
// body rows. The order by block improves cache use. The level of a row is 0 if it is coupled to no
// earlier row of its block, and otherwise one more than the largest level of the earlier rows to
// which it is coupled in its block. Rows of a block that have the same level do not depend on each
// other. The order within a block affects only rounding.
std::vector<Index> order_by_level(const BlockMatrix* matrix, Index n_rows) {
  std::vector<Index> level(n_rows, 0), order(n_rows);
  std::iota(order.begin(), order.end(), Index{0});
  const Index n_cloth = matrix ? matrix->n_rows() : 0;
  for (Index begin = 0; begin < n_cloth; begin += rows_per_block) {
    const Index end = std::min(n_cloth, begin + rows_per_block);
    for (Index row = begin; row < end; ++row)
      for (Index k = matrix->row_start()[row]; k < matrix->diagonal()[row]; ++k)
        if (matrix->columns()[k] >= begin)
          level[row] = std::max(level[row], level[matrix->columns()[k]] + 1);
    std::stable_sort(order.begin() + begin, order.begin() + end,
                     [&](Index a, Index b) { return level[a] < level[b]; });
  }
  return order;
}

struct Tables {
  const Index *order, *offset, *start, *column;
  const float *lower, *inverse;
  Index n_rows;
};

template <class Row>
LOOMSTONE_INLINE Row load_as(const float* p) {
  return __builtin_convertvector(quad_load(p), Row);
}
template <class Row>
LOOMSTONE_INLINE Row yzx(const Row& a) {
  return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}
template <class Row>
LOOMSTONE_INLINE Row zxy(const Row& a) {
  return __builtin_shufflevector(a, a, 2, 0, 1, 3);
}
template <class Row>
LOOMSTONE_INLINE Row inverse_times(const float* m, const Row& v) {
  return (load_as<Row>(m) * v[0] + load_as<Row>(m + 4) * v[1]) + load_as<Row>(m + 8) * v[2];
}

// Forward and backward sweep. Returns r . z. A block A is stored by its cyclic diagonals
// d = (00 11 22), b = (01 12 20) and c = (02 10 21):
//   A v = d v + b yzx(v) + c zxy(v),   A^T v = d v + yzx(c v) + zxy(b v),
// where products are taken entry by entry, and yzx(v) = (v_y, v_z, v_x), zxy(v) = (v_z, v_x, v_y).
template <class, class Scalar>
LOOMSTONE_INLINE double sweep(Tables s, const Scalar* r, Scalar* z, Scalar* t, Scalar* u) {
  using Row = std::conditional_t<std::is_same_v<Scalar, float>, FloatQuad, Quad>;
  const float* a = s.lower;
  for (Index place = 0; place < s.n_rows; ++place) {
    Row d{}, b{}, c{};
    for (Index k = s.start[place]; k < s.start[place + 1]; ++k, a += 9) {
      const Row v = quad_load(t + 4 * static_cast<std::size_t>(s.column[k]));
      d += load_as<Row>(a) * v;
      b += load_as<Row>(a + 3) * yzx(v);
      c += load_as<Row>(a + 6) * zxy(v);
    }
    const Scalar* residual = r + s.offset[place];
    const Row own = {residual[0], residual[8], residual[16], Scalar{0}};
    const std::size_t row = 4 * static_cast<std::size_t>(s.order[place]);
    quad_store(t + row, inverse_times(s.inverse + 12 * static_cast<std::size_t>(place),
                                      own - ((d + b) + c)));
    quad_store(u + row, Row{});
  }
  Quad sum{};
  for (Index place = s.n_rows; place-- > 0;) {
    const std::size_t row = 4 * static_cast<std::size_t>(s.order[place]);
    const Row v =
        quad_load(t + row) -
        inverse_times(s.inverse + 12 * static_cast<std::size_t>(place), quad_load(u + row));
    for (Index k = s.start[place + 1]; k-- > s.start[place];) {
      a -= 9;
      Scalar* other = u + 4 * static_cast<std::size_t>(s.column[k]);
      const Row f =
          load_as<Row>(a) * v + (yzx(load_as<Row>(a + 6) * v) + zxy(load_as<Row>(a + 3) * v));
      quad_store(other, quad_load(other) + f);
    }
    const Scalar* residual = r + s.offset[place];
    Scalar* out = z + s.offset[place];
    out[0] = v[0], out[8] = v[1], out[16] = v[2];
    const Row product =
        Row{residual[0], residual[8], residual[16], Scalar{0}} * Row{v[0], v[1], v[2], Scalar{0}};
    sum += __builtin_convertvector(product, Quad);
  }
  return quad_sum(sum);
}

}  // namespace

void SymmetricGaussSeidel::order_rows(const LinearSystem& system, const SlicedEllpack& slices) {
  const Index n_rows = slices.n_rows(), n_cloth = n_cloth_rows(system);
  order_ = order_by_level(system.matrix, n_rows);
  offset_.clear(), column_.clear(), source_.clear();
  start_.assign(1, 0);
  for (const Index row : order_) {
    offset_.push_back(24 * (slices.place[row] / 8) + slices.place[row] % 8);
    if (row < n_cloth)
      for (Index k = system.matrix->row_start()[row]; k < system.matrix->diagonal()[row]; ++k)
        column_.push_back(system.matrix->columns()[k]), source_.push_back(k);
    start_.push_back(static_cast<Index>(column_.size()));
  }
}

void SymmetricGaussSeidel::prepare(const LinearSystem& system, const SlicedEllpack& slices,
                                   const std::vector<float>& inverse) {
  static const std::vector<Index> none;
  const std::vector<Index>& start = system.matrix ? system.matrix->row_start() : none;
  const std::vector<Index>& columns = system.matrix ? system.matrix->columns() : none;
  if (static_cast<Index>(order_.size()) != slices.n_rows() || start != pattern_start_ ||
      columns != pattern_columns_) {
    order_rows(system, slices);
    pattern_start_ = start, pattern_columns_ = columns;
  }
  constexpr int entries[9] = {0, 4, 8, 3, 7, 2, 6, 1, 5};  // indices in a column-major block
  lower_.resize(9 * source_.size() + 3);
  for (std::size_t k = 0; k < source_.size(); ++k) {
    const double* block = system.matrix->block(source_[k]);
    for (int e = 0; e < 9; ++e) lower_[9 * k + e] = static_cast<float>(block[entries[e]]);
  }
  constexpr int upper[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
  inverse_.resize(12 * order_.size());
  for (std::size_t place = 0; place < order_.size(); ++place) {
    const Index lane = slices.place[order_[place]];
    const float* m = inverse.data() + 48 * static_cast<std::size_t>(lane / 8) + lane % 8;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) inverse_[12 * place + 4 * c + r] = m[8 * upper[3 * c + r]];
  }
}

template <>
double SymmetricGaussSeidel::apply(const std::vector<float>& r, std::vector<float>& z) {
  t_.resize(4 * order_.size()), u_.resize(4 * order_.size());
  const Tables tables{order_.data(),
                      offset_.data(),
                      start_.data(),
                      column_.data(),
                      lower_.data(),
                      inverse_.data(),
                      static_cast<Index>(order_.size())};
  return LOOMSTONE_WIDEST(sweep)(tables, r.data(), z.data(), t_.data(), u_.data());
}
template <>
double SymmetricGaussSeidel::apply(const std::vector<double>& r, std::vector<double>& z) {
  wide_t_.resize(4 * order_.size()), wide_u_.resize(4 * order_.size());
  const Tables tables{order_.data(),
                      offset_.data(),
                      start_.data(),
                      column_.data(),
                      lower_.data(),
                      inverse_.data(),
                      static_cast<Index>(order_.size())};
  return LOOMSTONE_WIDEST(sweep)(tables, r.data(), z.data(), wide_t_.data(), wide_u_.data());
}

}  // namespace loomstone
