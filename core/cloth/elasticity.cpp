#include "core/cloth/elasticity.h"

#include <algorithm>
#include <cstring>

namespace loomstone {

Vector lumped_mass(Index n_vertices, const Triangles& triangles,
                   const std::vector<Corners2>& corners, const std::vector<double>& density) {
  Vector mass = Vector::Zero(n_vertices);
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Vec2 e1 = (corners[t].row(1) - corners[t].row(0)).transpose();
    const Vec2 e2 = (corners[t].row(2) - corners[t].row(0)).transpose();
    const double third = density[t] * 0.5 * (e1.x() * e2.y() - e1.y() * e2.x()) / 3.0;
    for (int k = 0; k < 3; ++k) mass[triangles(t, k)] += third;
  }
  return mass;
}

namespace {
std::unique_ptr<Bending> make_bending(const ClothModel::BendingPart& part, bool lumped) {
  if (part.element == BendingElement::Hinge) return make_hinge_bending(part.setup);
  if (!lumped) return make_midedge_bending(part.setup);
  BendingSetup setup = part.setup;
  setup.lumped_stiffness = true;
  return make_midedge_bending(setup);
}

bool same_positions(const Points& a, const Points& b) {
  return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}
}  // namespace

Elasticity::Elasticity(const ClothModel& model, BendingTreatment bending)
    : model_(model),
      membrane_(model.n_vertices, model.triangles, model.corners, model.constants),
      treatment_(bending),
      zero_velocity_(Points::Zero(model.n_vertices, 3)) {
  if (!model.strain_limits.empty())
    limit_phase_ =
        std::make_unique<LimitPhase>(membrane_, model.strain_limits, model.strain_limit_of);
  std::vector<std::pair<Index, Index>> couplings;
  for (Index t = 0; t < model.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      couplings.emplace_back(model.triangles(t, k), model.triangles(t, (k + 1) % 3));
  for (const auto& part : model.bending) {
    bending_.push_back(make_bending(part, bending == BendingTreatment::Lumped));
    for (const double damping : part.setup.damping)
      damped_bending_ = damped_bending_ || damping > 0.0;
    if (!implicit_bending()) continue;
    const auto more = bending_.back()->couplings();
    couplings.insert(couplings.end(), more.begin(), more.end());
  }
  matrix_ = BlockMatrix(model.n_vertices, couplings);
  wide_in_.assign(4 * static_cast<std::size_t>(model.n_vertices) + 4, 0.0);
  wide_out_ = wide_in_;
}

double Elasticity::bending_eigenvalue(const ClothModel& model) {
  double largest = 0.0;
  for (const auto& part : model.bending)
    largest = std::max(largest, make_bending(part, false)->largest_eigenvalue(model.mass));
  return largest;
}

Elasticity::LimitPhaseScope Elasticity::limit_phase(const Team& team, const Points& x, Index begin,
                                                    Index end) {
  if (!limit_phase_) return {};
  limit_phase_->enter(team, x, begin, end);
  membrane_.set_phase(limit_phase_->table(), limit_phase_->entered());
  return LimitPhaseScope(membrane_);
}

template <class Add>
void Elasticity::add_known(const Team& team, const Points& x, Range rows, Known& known, Add&& add,
                           Points& force) const {
  if (rows != known.rows || !same_positions(x, known.x)) {
    known.x = x, known.rows = rows;
    known.force.setZero(x.rows(), 3);
    add(known.force);
  }
  parallel_for(team, rows.end - rows.begin,
               [&](Index i) { force.row(rows.begin + i) += known.force.row(rows.begin + i); });
}

void Elasticity::add_implicit_forces(const Team& team, const Points& x, const Points* v,
                                     Index begin, Index end, Points& force) {
  const auto add = [&](Points& to) { membrane_.add_forces(team, x, v, begin, end, to); };
  if (membrane_.in_phase() || (v && membrane_.viscous()))
    add(force);
  else
    add_known(team, x, {begin, end}, membrane_force_, add, force);
  if (implicit_bending()) add_bending_forces(team, x, v, begin, end, force);
}

void Elasticity::add_explicit_bending(const Team& team, const Points& x, const Points& v,
                                      Index begin, Index end, Points& force) {
  if (!implicit_bending()) add_bending_forces(team, x, &v, begin, end, force);
}

void Elasticity::add_bending_forces(const Team& team, const Points& x, const Points* v, Index begin,
                                    Index end, Points& force) {
  if (bending_.empty()) return;
  const auto add = [&](Points& to) {
    for (const auto& element : bending_)
      element->add_forces(team, x, v ? *v : zero_velocity_, begin, end, to);
  };
  if (v && damped_bending_)
    add(force);
  else
    add_known(team, x, {begin, end}, bending_force_, add, force);
}

void Elasticity::add_limits(const std::vector<LimitModes>& modes) {
  membrane_.add_limits(modes);
  membrane_force_ = membrane_energy_ = {};
}

// If bending is not implicit, each chunk of rows is completed while it is in the cache.
void Elasticity::assemble(const Team& team, const Points& x, JacobianTerms terms, Index begin,
                          Index end, Product product) {
  if (product.w)
    parallel_for(team, model_.n_vertices, [&](Index i) {
      for (int d = 0; d < 3; ++d)
        wide_in_[4 * static_cast<std::size_t>(i) + d] = (*product.w)(i, d);
    });
  membrane_.locate_rows(matrix_, begin, end);
  const Index n_chunks = (end - begin + rows_per_block - 1) / rows_per_block;
  const auto end_of = [&](Index chunk) {
    return std::min(end, begin + (chunk + 1) * rows_per_block);
  };
  parallel_ranges(team, n_chunks, 1, [&](Index first, Index last) {
    AlignedDoubles scratch;
    for (Index chunk = first; chunk < last; ++chunk) {
      membrane_.set_chunk(chunk, x, terms, scratch, matrix_);
      if (!implicit_bending()) finish_rows(begin + chunk * rows_per_block, end_of(chunk), product);
    }
  });
  if (!implicit_bending()) return;
  add_bending(team, x, terms, begin, end);
  parallel_ranges(team, n_chunks, 1, [&](Index first, Index last) {
    finish_rows(begin + first * rows_per_block, end_of(last - 1), product);
  });
}

void Elasticity::add_bending(const Team& team, const Points& x, JacobianTerms terms, Index begin,
                             Index end) {
  for (const auto& element : bending_) {
    element->add_stiffness(team, x, terms.scales, begin, end, matrix_);
    if (terms.kind == JacobianKind::Exact)
      element->add_geometric_stiffness(team, x, terms.scales.elastic, begin, end, matrix_);
  }
}

// Multiplies rows [begin, end) of the matrix by product.w, and then adds the mass to these rows.
// The product therefore excludes the mass.
void Elasticity::finish_rows(Index begin, Index end, Product product) {
  if (product.w) {
    matrix_.multiply(begin, end, wide_in_.data(), wide_out_.data());
    for (Index row = begin; row < end; ++row)
      for (int d = 0; d < 3; ++d)
        (*product.y)(row, d) = wide_out_[4 * static_cast<std::size_t>(row) + d];
  }
  for (Index row = begin; row < end; ++row) {
    double* diagonal = matrix_.block(matrix_.diagonal()[row]);
    for (const int entry : {0, 4, 8}) diagonal[entry] += model_.mass[row];
  }
}

double Elasticity::membrane_energy(const Team& team, const Points& x) {
  if (membrane_.in_phase()) return membrane_.energy(team, x);
  if (!same_positions(x, membrane_energy_.x))
    membrane_energy_.x = x, membrane_energy_.energy = membrane_.energy(team, x);
  return membrane_energy_.energy;
}

double Elasticity::bending_energy(const Team& team, const Points& x) {
  if (same_positions(x, bending_energy_.x)) return bending_energy_.energy;
  double sum = 0.0;
  for (const auto& element : bending_) sum += element->energy(team, x);
  bending_energy_.x = x, bending_energy_.energy = sum;
  return sum;
}

}  // namespace loomstone
