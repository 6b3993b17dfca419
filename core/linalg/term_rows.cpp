#include "core/linalg/term_rows.h"

#include "core/linalg/flush_to_zero.h"
#include "core/linalg/quad.h"

namespace loomstone {

namespace {

LOOMSTONE_INLINE Quad quad_of(const Vec3& v) { return Quad{v[0], v[1], v[2], 0.0}; }

LOOMSTONE_INLINE Quad wide(const Quad& a) { return a; }
LOOMSTONE_INLINE Quad wide(const FloatQuad& a) { return __builtin_convertvector(a, Quad); }

}  // namespace

void TermRows::build(const ExtraTerms* terms, double scale, const RowLayout& layout) {
  scale_ = scale;
  hessians_.clear(), parts_.clear(), arms_.clear(), touched_.clear();
  if (terms == nullptr || terms->empty()) return;

  part_start_.assign(1, 0);
  row_start_.assign(layout.n_rows() + 1, 0);
  for (const ExtraTerm& term : *terms) {
    const auto end = term.entries.begin() + term.n_entries;
    if (std::none_of(term.entries.begin(), end,
                     [&](const TermEntry& e) { return layout.owns(e.row); }))
      continue;
    for (auto e = term.entries.begin(); e != end; ++e) {
      parts_.push_back({e->row, e->rotation ? static_cast<Index>(arms_.size()) : -1, e->weight});
      if (e->rotation) arms_.push_back(e->arm);
      if (layout.owns(e->row)) ++row_start_[e->row + 1];
    }
    part_start_.push_back(static_cast<Index>(parts_.size()));
    hessians_.push_back(term.hessian);
  }
  for (Index row = 0; row < layout.n_rows(); ++row) {
    if (row_start_[row + 1] > 0) touched_.push_back(row);
    row_start_[row + 1] += row_start_[row];
  }
  slots_.resize(row_start_.back());
  for (std::size_t t = 0; t < hessians_.size(); ++t)
    for (Index p = part_start_[t]; p < part_start_[t + 1]; ++p)
      if (layout.owns(parts_[p].row))
        slots_[row_start_[parts_[p].row]++] = {static_cast<Index>(t), parts_[p].arm,
                                               parts_[p].weight};
  // Filling has moved each start to the start of the next row. This loop restores the starts.
  for (Index row = layout.n_rows(); row > 0; --row) row_start_[row] = row_start_[row - 1];
  row_start_[0] = 0;
  forces_.resize(4 * hessians_.size());
  // find_forces() computes scale H u, with u = sum J x, and adds the products of the three columns
  // in order. In row 2, the columns are rotated to 1, 2, 0, so that the products are added in the
  // same order as in Eigen's matrix product.
  scaled_.assign(12 * hessians_.size(), 0.0);
  for (std::size_t t = 0; t < hessians_.size(); ++t)
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row)
        scaled_[12 * t + 4 * column + row] =
            scale * hessians_[t](row, row < 2 ? column : (column + 1) % 3);
}

template <class Lanes, class Scalar>
LOOMSTONE_INLINE void TermRows::find_forces(TermRows& rows, Index begin, Index end,
                                            const Scalar* x) {
  for (Index t = begin; t < end; ++t) {
    Quad u{};
    for (Index p = rows.part_start_[t]; p < rows.part_start_[t + 1]; ++p) {
      const Part& part = rows.parts_[p];
      const Quad v = wide(quad_load(x + 4 * static_cast<std::size_t>(part.row)));
      u += part.arm < 0
               ? part.weight * v
               : quad_of(rows.entry(part.row, part.arm, part.weight).apply(Vec3(v[0], v[1], v[2])));
    }
    const double* const h = rows.scaled_.data() + 12 * static_cast<std::size_t>(t);
    const Quad force = quad_load(h) * Quad{u[0], u[0], u[1], 0.0} +
                       quad_load(h + 4) * Quad{u[1], u[1], u[2], 0.0} +
                       quad_load(h + 8) * Quad{u[2], u[2], u[0], 0.0};
    quad_store(rows.forces_.data() + 4 * static_cast<std::size_t>(t), force);
  }
}

template <class Scalar>
void TermRows::evaluate(const Team& team, const Scalar* x) {
  if (empty()) return;
  parallel_ranges(team, static_cast<Index>(hessians_.size()), 128, [&](Index begin, Index end) {
    const FlushToZero flush;
    LOOMSTONE_WIDEST(find_forces)(*this, begin, end, x);
  });
}

// This function is not compiled for several instruction sets, because for the few terms of a row,
// selecting the version at run time would cost more than wider vectors save. QuarterLanes contains
// two doubles, which every x86-64 processor adds as a vector.
Vec3 TermRows::force(Index row) const {
  QuarterLanes sum{};
  double sum_z = 0.0;
  for (Index k = row_start_[row]; k < row_start_[row + 1]; ++k) {
    const Slot& slot = slots_[k];
    const double* const force = forces_.data() + 4 * static_cast<std::size_t>(slot.term);
    if (slot.arm >= 0) {
      const Vec3 of_body =
          entry(row, slot.arm, slot.weight).apply_transposed(Vec3(force[0], force[1], force[2]));
      sum += QuarterLanes{of_body[0], of_body[1]}, sum_z += of_body[2];
      continue;
    }
    QuarterLanes first;
    __builtin_memcpy(&first, force, sizeof first);
    sum += slot.weight * first, sum_z += slot.weight * force[2];
  }
  return {sum[0], sum[1], sum_z};
}

template void TermRows::evaluate(const Team&, const double*);
template void TermRows::evaluate(const Team&, const float*);

Mat3 TermRows::diagonal(Index row) const {
  Mat3 sum = Mat3::Zero();
  for (Index k = row_start_[row]; k < row_start_[row + 1];) {
    // A row can occur in a term more than once.
    const Index t = slots_[k].term;
    const bool once = k + 1 == row_start_[row + 1] || slots_[k + 1].term != t;
    if (once && slots_[k].arm < 0) {
      const double weight = slots_[k++].weight;
      sum += scale_ * weight * hessians_[t] * weight;
      continue;
    }
    Mat3 jacobian = Mat3::Zero();
    for (; k < row_start_[row + 1] && slots_[k].term == t; ++k)
      jacobian += entry(row, slots_[k].arm, slots_[k].weight).jacobian();
    sum += scale_ * (jacobian.transpose() * hessians_[t] * jacobian);
  }
  return sum;
}

}  // namespace loomstone
