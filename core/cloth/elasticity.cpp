#include "core/cloth/elasticity.h"

#include <algorithm>

namespace loomstone {

Vector lumped_mass(Index n_vertices, const Triangles& triangles, const std::vector<Corners2>& corners,
                   const std::vector<double>& density) {
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
  if (part.element == "hinge") return make_hinge_bending(part.setup);
  if (!lumped) return make_midedge_bending(part.setup);
  BendingSetup setup = part.setup;
  setup.lumped_stiffness = true;
  return make_midedge_bending(setup);
}
}  // namespace

Elasticity::Elasticity(const ClothModel& model, BendingTreatment bending)
    : model_(model),
      membrane_(model.n_vertices, model.triangles, model.corners, model.constants),
      treatment_(bending),
      zero_velocity_(Points::Zero(model.n_vertices, 3)) {
  std::vector<std::pair<Index, Index>> couplings;
  for (Index t = 0; t < model.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) couplings.emplace_back(model.triangles(t, k), model.triangles(t, (k + 1) % 3));
  for (const auto& part : model.bending) {
    bending_.push_back(make_bending(part, bending == BendingTreatment::Lumped));
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
  for (const auto& part : model.bending) largest = std::max(largest, make_bending(part, false)->largest_eigenvalue(model.mass));
  return largest;
}

void Elasticity::add_implicit_forces(const Team& team, const Points& x, const Points* v, Index begin, Index end,
                                     Points& force) {
  membrane_.add_forces(team, x, v, begin, end, force);
  if (!implicit_bending()) return;
  for (const auto& element : bending_) element->add_forces(team, x, v ? *v : zero_velocity_, begin, end, force);
}

void Elasticity::add_explicit_bending(const Team& team, const Points& x, const Points& v, Index begin, Index end,
                                      Points& force) {
  if (implicit_bending()) return;
  for (const auto& element : bending_) element->add_forces(team, x, v, begin, end, force);
}

void Elasticity::assemble(const Team& team, const Points& x, JacobianKind kind, double scale_d, double scale_k,
                          Index begin, Index end) {
  parallel_for(team, end - begin, [&](Index i) {
    const Index row = begin + i;
    double* first = matrix_.block(matrix_.row_start()[row]);
    std::fill(first, matrix_.block(matrix_.row_start()[row + 1] - 1) + 9, 0.0);
    double* diagonal = matrix_.block(matrix_.diagonal()[row]);
    diagonal[0] = diagonal[4] = diagonal[8] = model_.mass[row];
  });
  membrane_.add_jacobian(team, x, kind, scale_k, scale_d, begin, end, matrix_);
  if (!implicit_bending()) return;
  for (const auto& element : bending_) {
    element->add_stiffness(team, x, scale_k, scale_d, begin, end, matrix_);
    if (kind == JacobianKind::Exact) element->add_geometric_stiffness(team, x, scale_k, begin, end, matrix_);
  }
}

void Elasticity::multiply_without_mass(const Team& team, const Points& w, Index begin, Index end, Points& y) {
  parallel_for(team, model_.n_vertices, [&](Index i) {
    for (int d = 0; d < 3; ++d) wide_in_[4 * i + d] = w(i, d);
  });
  parallel_ranges(team, end - begin, 512, [&](Index first, Index last) {
    matrix_.multiply(begin + first, begin + last, wide_in_.data(), wide_out_.data());
    for (Index row = begin + first; row < begin + last; ++row)
      for (int d = 0; d < 3; ++d) y(row, d) = wide_out_[4 * row + d] - model_.mass[row] * w(row, d);
  });
}

double Elasticity::bending_energy(const Team& team, const Points& x) const {
  double sum = 0.0;
  for (const auto& element : bending_) sum += element->energy(team, x);
  return sum;
}

}  // namespace loomstone
