#include "core/linalg/term_rows.h"

namespace loomstone {

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
  forces_.resize(hessians_.size());
}

template <class Scalar>
void TermRows::evaluate(const Team& team, const Scalar* x) {
  if (empty()) return;
  parallel_for(
      team, static_cast<Index>(hessians_.size()),
      [&](Index t) {
        Vec3 u = Vec3::Zero();
        for (Index p = part_start_[t]; p < part_start_[t + 1]; ++p) {
          const Part& part = parts_[p];
          const Vec3 v =
              Eigen::Map<const Eigen::Vector3<Scalar>>(x + 4 * static_cast<std::size_t>(part.row))
                  .template cast<double>();
          u += part.arm < 0 ? Vec3(part.weight * v)
                            : entry(part.row, part.arm, part.weight).apply(v);
        }
        forces_[t] = scale_ * (hessians_[t] * u);
      },
      128);
}

Vec3 TermRows::force(Index row) const {
  Vec3 sum = Vec3::Zero();
  for (Index k = row_start_[row]; k < row_start_[row + 1]; ++k) {
    const Slot& slot = slots_[k];
    const Vec3& force = forces_[slot.term];
    sum += slot.arm < 0 ? Vec3(slot.weight * force)
                        : entry(row, slot.arm, slot.weight).apply_transposed(force);
  }
  return sum;
}

template void TermRows::evaluate(const Team&, const double*);
template void TermRows::evaluate(const Team&, const float*);

Mat3 TermRows::diagonal(Index row) const {
  Mat3 sum = Mat3::Zero();
  for (Index k = row_start_[row]; k < row_start_[row + 1];) {
    // A row can occur in a term more than once.
    const Index t = slots_[k].term;
    Mat3 jacobian = Mat3::Zero();
    for (; k < row_start_[row + 1] && slots_[k].term == t; ++k)
      jacobian += entry(row, slots_[k].arm, slots_[k].weight).jacobian();
    sum += scale_ * (jacobian.transpose() * hessians_[t] * jacobian);
  }
  return sum;
}

}  // namespace loomstone
