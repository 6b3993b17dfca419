#include "core/linalg/term_rows.h"

namespace loomstone {

void TermRows::build(const ExtraTerms* terms, double scale, const RowLayout& layout) {
  terms_ = terms;
  scale_ = scale;
  involved_.clear();
  if (terms == nullptr || terms->empty()) return;

  const Index n_terms = static_cast<Index>(terms->size());
  row_start_.assign(layout.n_rows() + 1, 0);
  for (Index t = 0; t < n_terms; ++t) {
    bool owned = false;
    for (int e = 0; e < (*terms)[t].n_entries; ++e) {
      const Index row = (*terms)[t].entries[e].row;
      if (!layout.owns(row)) continue;
      ++row_start_[row + 1];
      owned = true;
    }
    if (owned) involved_.push_back(t);
  }
  for (Index row = 0; row < layout.n_rows(); ++row) row_start_[row + 1] += row_start_[row];
  slots_.resize(row_start_.back());
  for (const Index t : involved_)
    for (int e = 0; e < (*terms)[t].n_entries; ++e) {
      const Index row = (*terms)[t].entries[e].row;
      if (layout.owns(row)) slots_[row_start_[row]++] = {t, e};
    }
  // Filling moved every start to its end, which is the next row's start.
  for (Index row = layout.n_rows(); row > 0; --row) row_start_[row] = row_start_[row - 1];
  row_start_[0] = 0;
  forces_.resize(n_terms);
}

template <class Scalar>
void TermRows::evaluate(const Team& team, const Scalar* x) {
  parallel_for(
      team, static_cast<Index>(involved_.size()),
      [&](Index i) {
        const ExtraTerm& term = (*terms_)[involved_[i]];
        Vec3 u = Vec3::Zero();
        for (int e = 0; e < term.n_entries; ++e)
          u += term.entries[e].apply(
              Eigen::Map<const Eigen::Vector3<Scalar>>(x + 4 * static_cast<std::size_t>(term.entries[e].row))
                  .template cast<double>());
        forces_[involved_[i]] = scale_ * (term.hessian * u);
      },
      128);
}

Vec3 TermRows::force(Index row) const {
  Vec3 sum = Vec3::Zero();
  for (Index k = row_start_[row]; k < row_start_[row + 1]; ++k)
    sum += (*terms_)[slots_[k].term].entries[slots_[k].entry].apply_transposed(forces_[slots_[k].term]);
  return sum;
}

template void TermRows::evaluate(const Team&, const double*);
template void TermRows::evaluate(const Team&, const float*);

Mat3 TermRows::diagonal(Index row) const {
  Mat3 sum = Mat3::Zero();
  for (Index k = row_start_[row]; k < row_start_[row + 1];) {
    // A row may enter a term more than once.
    const Index t = slots_[k].term;
    Mat3 jacobian = Mat3::Zero();
    for (; k < row_start_[row + 1] && slots_[k].term == t; ++k)
      jacobian += (*terms_)[t].entries[slots_[k].entry].jacobian();
    sum += scale_ * (jacobian.transpose() * (*terms_)[t].hessian * jacobian);
  }
  return sum;
}

}  // namespace loomstone
