#include "core/linalg/preconditioner.h"

#include <algorithm>
#include <array>

#include "core/linalg/system.h"

namespace loomstone {

namespace {

// Returns the offset of the inverse diagonal blocks of a slice in the arrays of inverses.
std::size_t inverse_at(Index slice) { return 48 * static_cast<std::size_t>(slice); }

// Writes the inverse diagonal blocks of a slice to `out` (6 x 8), with zeros for fixed rows and
// empty lanes. Returns the lowest row of the slice whose block is not positive definite, or the
// number of all rows if there is none.
Index invert_slice(const LinearSystem& system, const TermRows& terms, const SlicedEllpack& slices,
                   Index slice, float* out) {
  const Index* rows = slices.rows.data() + 8 * static_cast<std::size_t>(slice);
  const auto is_free = [&](Index row) { return row < slices.n_rows() && !is_fixed(system, row); };
  alignas(64) double blocks[48];
  for (int l = 0; l < 8; ++l) {
    const Mat3 block =
        is_free(rows[l]) ? diagonal_block(system, terms, rows[l]) : Mat3(Mat3::Identity());
    const double upper[6] = {block(0, 0), block(0, 1), block(0, 2),
                             block(1, 1), block(1, 2), block(2, 2)};
    for (int e = 0; e < 6; ++e) blocks[8 * e + l] = upper[e];
  }
  const unsigned bad = pcg::invert(blocks);
  Index first_bad = slices.n_rows();
  for (int l = 0; l < 8; ++l) {
    if (bad >> l & 1) first_bad = std::min(first_bad, rows[l]);
    // The increment exceeds the rounding error of single precision, so that the stored block stays
    // positive definite.
    const double more = 0x1p-22 * (blocks[l] + blocks[24 + l] + blocks[40 + l]);
    for (const int e : {0, 3, 5}) blocks[8 * e + l] += more;
    for (int e = 0; e < 6; ++e)
      out[8 * e + l] = is_free(rows[l]) ? static_cast<float>(blocks[8 * e + l]) : 0.0f;
  }
  return first_bad;
}

}  // namespace

void Preconditioner::make(Kind kind, const RowLoops& loops, const LinearSystem& system,
                          const Rows& rows) {
  kind_ = kind;
  uses_levels_ = kind == Kind::Multigrid && n_cloth_rows(system) > 0;
  invert_diagonal(loops, system, rows);
  if (kind == Kind::GaussSeidel) gauss_seidel_.prepare(system, rows.slices, inverse_);
  if (uses_levels_) make_levels(loops, system, rows);
}

void Preconditioner::invert_diagonal(const RowLoops& loops, const LinearSystem& system,
                                     const Rows& rows) {
  const SlicedEllpack& slices = rows.slices;
  const Index none = slices.n_rows();
  inverse_.resize(inverse_at(slices.n_slices()));
  std::vector<Index> bad_rows(loops.n_blocks(), none);
  loops.over_blocks([&](Index block, Index begin, Index end) {
    for (Index slice = slices.first_slice(begin); slice < slices.last_slice(end); ++slice) {
      float* const out = inverse_.data() + inverse_at(slice);
      bad_rows[block] =
          std::min(bad_rows[block], invert_slice(system, rows.terms, slices, slice, out));
    }
  });
  const Index bad_row = *std::min_element(bad_rows.begin(), bad_rows.end());
  refuse_indefinite_row(system, bad_row < none ? bad_row : -1);
}

void Preconditioner::make_levels(const RowLoops& loops, const LinearSystem& system,
                                 const Rows& rows) {
  if (!has_levels_) levels_.set_pattern(*system.matrix, loops.layout());
  has_levels_ = true;
  levels_.prepare(loops.team(), system, rows.halo);
  uses_levels_ = levels_.usable();
  const SlicedEllpack& slices = rows.slices;
  slots_.resize(slices.rows.size());
  loops.over_blocks([&](Index block, Index begin, Index end) {
    for (Index place = 8 * slices.first_slice(begin); place < 8 * slices.last_slice(end); ++place) {
      const Index row = slices.rows[place];
      slots_[place] = row < slices.n_rows() ? levels_.slot(row) : levels_.unused_slot(block);
    }
  });
}

void Preconditioner::widen(const RowLoops& loops, const SlicedEllpack& slices) {
  wide_inverse_.resize(inverse_.size());
  loops.over_blocks([&](Index, Index begin, Index end) {
    const std::size_t first = inverse_at(slices.first_slice(begin)),
                      last = inverse_at(slices.last_slice(end));
    std::copy(inverse_.begin() + first, inverse_.begin() + last, wide_inverse_.begin() + first);
  });
  if (uses_levels_) levels_.widen();
}

template <>
const float* Preconditioner::inverse<float>() const {
  return inverse_.data();
}
template <>
const double* Preconditioner::inverse<double>() const {
  return wide_inverse_.data();
}

template <class Scalar>
Preconditioner::StepProducts Preconditioner::complete_product(const RowLayout& layout,
                                                              BinnedSum curvature) {
  if (!uses_levels_) {
    layout.communicator().add(&curvature, 1);
    return {curvature.value(), products_.whole};
  }
  std::array<BinnedSum, 2> sums = {curvature, levels_.correction_product()};
  layout.communicator().start_add(sums.data(), 2);
  levels_.start_exchange(layout, levels_.vectors<Scalar>().q);
  layout.communicator().finish();
  levels_.finish_exchange();
  return {sums[0].value(), products_.diagonal + sums[1].value()};
}

template <class Scalar>
Preconditioner::Products Preconditioner::complete(const RowLoops& loops, BinnedSum square,
                                                  const std::vector<Scalar>& r,
                                                  std::vector<Scalar>& z) {
  double product = 0.0;
  if (uses_levels_) {
    product = levels_.solve<Scalar>(loops.team(), loops.layout(), square);
    uses_levels_ = product >= 0.0;
  } else {
    loops.layout().communicator().add(&square, 1);
  }
  const double diagonal = square.value();
  products_ = {diagonal, uses_levels_ ? diagonal + product : diagonal};
  if (kind_ == Kind::GaussSeidel) products_.whole = gauss_seidel_.apply(r, z);
  return products_;
}

template Preconditioner::StepProducts Preconditioner::complete_product<float>(const RowLayout&,
                                                                              BinnedSum);
template Preconditioner::StepProducts Preconditioner::complete_product<double>(const RowLayout&,
                                                                               BinnedSum);
template Preconditioner::Products Preconditioner::complete(const RowLoops&, BinnedSum,
                                                           const std::vector<float>&,
                                                           std::vector<float>&);
template Preconditioner::Products Preconditioner::complete(const RowLoops&, BinnedSum,
                                                           const std::vector<double>&,
                                                           std::vector<double>&);

}  // namespace loomstone
