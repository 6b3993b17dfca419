#include "core/cloth/elasticity.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "core/base/same_bits.h"
#include "core/cloth/bending/bending_subset.h"

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

BendingSetup ClothModel::setup_of(const BendingPart& part) const {
  const Index first = first_triangle[part.cloth], last = first_triangle[part.cloth + 1];
  BendingSetup setup;
  setup.rest_positions = rest_positions.all();
  setup.triangles = triangles.middleRows(first, last - first);
  setup.corners = corners.range(first, last);
  setup.rigidity.assign(last - first, part.rigidity);
  setup.damping.assign(last - first, part.damping);
  setup.prescribed = prescribed;
  setup.flat_rest = part.flat_rest;
  return setup;
}

namespace {

std::unique_ptr<Bending> make_bending(BendingElement element, const BendingSetup& setup) {
  return element == BendingElement::Hinge ? make_hinge_bending(setup) : make_midedge_bending(setup);
}

Membrane make_membrane(const ClothModel& model, const RowLayout* layout,
                       const std::vector<Index>& first) {
  const MeshPart all = {{0, model.n_vertices}, {0, static_cast<Index>(model.triangles.rows())}};
  const MembraneConstantsOf constants(model.constants, model.first_triangle);
  return Membrane(model.triangles, model.corners.all(), constants, model.n_vertices,
                  layout ? part_of_rank(*layout, first) : all);
}

}  // namespace

Elasticity::Elasticity(const ClothModel& model, BendingTreatment bending)
    : Elasticity(model, bending, nullptr) {}

Elasticity::Elasticity(const ClothModel& model, BendingTreatment bending, const RowLayout& layout)
    : Elasticity(model, bending, layout.single() ? nullptr : &layout) {}

Elasticity::Elasticity(const ClothModel& model, BendingTreatment bending, const RowLayout* layout)
    : model_(model),
      layout_(layout),
      first_(layout ? first_triangles(model.triangles, *layout) : std::vector<Index>()),
      membrane_(make_membrane(model, layout, first_)),
      treatment_(bending) {
  if (!model.strain_limits.empty())
    limit_phase_ =
        std::make_unique<LimitPhase>(membrane_, model.strain_limits, model.strain_limit_of);
  const Index begin = layout ? std::min(layout->begin(), model.n_vertices) : 0,
              end = layout ? std::min(layout->end(), model.n_vertices) : model.n_vertices;
  std::vector<std::pair<Index, Index>> couplings;
  const MeshPart rows = {{begin, end}, {}};
  for (Index t = 0; t < model.triangles.rows(); ++t)
    for (int k = 0; k < 3 && rows.contains(model.triangles, t); ++k)
      couplings.emplace_back(model.triangles(t, k), model.triangles(t, (k + 1) % 3));
  for (const auto& part : model.bending) {
    add_bending_part(part);
    damped_bending_ = damped_bending_ || part.damping > 0.0;
    if (!implicit_bending()) continue;
    const auto more = bending_.back().element->couplings();
    couplings.insert(couplings.end(), more.begin(), more.end());
  }
  matrix_ = BlockMatrix(model.n_vertices, couplings, begin, end);
  unknown_ =
      KnownPositions({begin, end}, layout ? other_rows_read({begin, end}) : std::vector<Index>());
  known_.at = energies_.at = unknown_;
}

// The result includes corners of triangles that do not touch the rows of this rank, because a batch
// of membrane elements or a bending element may read such corners.
std::vector<Index> Elasticity::other_rows_read(Range rows) const {
  std::vector<std::uint8_t> read(model_.n_vertices, 0);
  const auto read_corners = [&](Index triangle) {
    for (int k = 0; k < 3; ++k) read[model_.triangles(triangle, k)] = 1;
  };
  for (Index place = 0; place < membrane_.n_batches(); ++place) {
    const Index first = 8 * membrane_.batch_at(place);
    for (Index t = first; t < std::min(first + 8, membrane_.n_triangles()); ++t) read_corners(t);
  }
  for (const BendingElements& of_part : bending_)
    for (const Hinge& hinge : of_part.element->hinges())
      for (const Index vertex : hinge.vertices) read[vertex] = 1;
  std::vector<Index> others;
  for (Index row = 0; row < model_.n_vertices; ++row)
    if (read[row] && (row < rows.begin || row >= rows.end)) others.push_back(row);
  return others;
}

void Elasticity::add_bending_part(const ClothModel::BendingPart& part) {
  BendingElements made;
  BendingSetup setup = model_.setup_of(part);
  const Index n = static_cast<Index>(setup.triangles.rows());
  // The hinge energy is not a sum over triangles, so every rank stores all hinge elements.
  const bool divided = layout_ && part.element != BendingElement::Hinge;
  if (divided) made.first = first_triangles(setup.triangles, *layout_);
  BendingOfPart own = divided ? bending_of_part(setup, part_of_rank(*layout_, made.first))
                              : BendingOfPart{std::move(setup), {0, n}};
  own.setup.keeps_rest = false;
  if (treatment_ == BendingTreatment::Lumped) own.setup.lumped_stiffness = true;
  made.element = make_bending(part.element, own.setup);
  made.triangles = own.triangles;
  bending_.push_back(std::move(made));
}

double Elasticity::bending_eigenvalue(const ClothModel& model) {
  double largest = 0.0;
  for (const auto& part : model.bending) {
    BendingSetup setup = model.setup_of(part);
    setup.forces_only = true;
    largest = std::max(largest, make_bending(part.element, setup)->largest_eigenvalue(model.mass));
  }
  return largest;
}

Elasticity::LimitPhaseScope Elasticity::limit_phase(const Team& team, const Points& x, Index begin,
                                                    Index end, const std::uint8_t* yields,
                                                    double recovery) {
  if (!limit_phase_) return {};
  in_limit_phase_ = limit_phase_->enter(team, x, begin, end, yields, recovery);
  return last_limit_phase();
}

Elasticity::LimitPhaseScope Elasticity::last_limit_phase() {
  if (!limit_phase_) return {};
  membrane_.set_phase(limit_phase_->table(), limit_phase_->entered());
  return LimitPhaseScope(membrane_);
}

void Elasticity::add_phase_forces(const Team& team, const Points& x, Index begin, Index end,
                                  RowsOut force) {
  if (!limit_phase_) return;
  OwnRows with, without;
  for (OwnRows* rows : {&with, &without}) {
    rows->resize(begin, end);
    std::fill_n(rows->data(), 3 * static_cast<std::size_t>(end - begin), 0.0);
  }
  const auto add = [&](RowsOut to) { membrane_.add_forces(team, x, nullptr, begin, end, to); };
  add_known(team, x, {begin, end}, known_.membrane, add, RowsOut(without));
  const LimitPhaseScope phase = last_limit_phase();
  add(RowsOut(with));
  parallel_for(team, end - begin, [&](Index i) {
    force.row(begin + i) += with.row(begin + i) - without.row(begin + i);
  });
}

void Elasticity::know_forces_at(const Points& x, Range rows) {
  if (known_.rows == rows && known_.at.at(x)) return;
  known_.membrane.known = known_.bending.known = false;
  known_.rows = rows;
  known_.at.set(x);
}

template <class Add>
void Elasticity::add_known(const Team& team, const Points& x, Range rows, KnownForce& known,
                           Add&& add, RowsOut force) {
  know_forces_at(x, rows);
  const Index n = rows.end - rows.begin;
  if (!known.known) {
    known.force.resize(rows.begin, rows.end);
    std::fill_n(known.force.data(), 3 * static_cast<std::size_t>(n), 0.0);
    add(RowsOut(known.force));
    known.known = true;
  }
  parallel_for(team, n,
               [&](Index i) { force.row(rows.begin + i) += known.force.row(rows.begin + i); });
}

void Elasticity::add_implicit_forces(const Team& team, const Points& x, const Points* v,
                                     Index begin, Index end, RowsOut force) {
  const auto add = [&](RowsOut to) { membrane_.add_forces(team, x, v, begin, end, to); };
  if (membrane_.in_phase() || (v && membrane_.viscous()))
    add(force);
  else
    add_known(team, x, {begin, end}, known_.membrane, add, force);
  if (implicit_bending()) add_bending_forces(team, x, v, begin, end, force);
}

void Elasticity::add_explicit_bending(const Team& team, const Points& x, const Points& v,
                                      Index begin, Index end, RowsOut force) {
  if (!implicit_bending()) add_bending_forces(team, x, &v, begin, end, force);
}

void Elasticity::add_bending_forces(const Team& team, const Points& x, const Points* v, Index begin,
                                    Index end, RowsOut force) {
  if (bending_.empty()) return;
  if (!v && damped_bending_ && zero_velocity_.rows() == 0)
    zero_velocity_.setZero(model_.n_vertices, 3);
  // Elements without damping do not read velocities.
  const Points& velocity = v ? *v : damped_bending_ ? zero_velocity_ : x;
  const auto add = [&](RowsOut to) {
    for (const auto& of_part : bending_)
      of_part.element->add_forces(team, x, velocity, begin, end, to);
  };
  if (v && damped_bending_)
    add(force);
  else
    add_known(team, x, {begin, end}, known_.bending, add, force);
}

void Elasticity::add_limits(const std::vector<LimitModes>& modes) {
  membrane_.add_limits(modes);
  known_.membrane.known = false;
  energies_.membrane.clear();
}

// If bending is explicit, finish_rows() completes each chunk of rows while it is in the cache.
void Elasticity::assemble(const Team& team, const Points& x, JacobianTerms terms, Index begin,
                          Index end, Product product) {
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
  for (const auto& of_part : bending_) {
    of_part.element->add_stiffness(team, x, terms.scales, begin, end, matrix_);
    if (terms.kind == JacobianKind::Exact)
      of_part.element->add_geometric_stiffness(team, x, terms.scales.elastic, begin, end, matrix_);
  }
}

// Sets rows [begin, end) of product.y to the product of the matrix and product.w, unless product.w
// is null. Then adds the mass to these rows of the matrix. The product therefore excludes the mass.
void Elasticity::finish_rows(Index begin, Index end, Product product) {
  for (Index first = begin; product.w && first < end; first += rows_per_block) {
    alignas(64) double out[4 * rows_per_block];
    const Index last = std::min(end, first + rows_per_block);
    matrix_.multiply(first, last, product.w->data(), out, 3);
    for (Index row = first; row < last; ++row)
      for (int d = 0; d < 3; ++d) product.y->row(row)[d] = out[4 * (row - first) + d];
  }
  for (Index row = begin; row < end; ++row) {
    double* diagonal = matrix_.block(matrix_.diagonal()[row]);
    for (const int entry : {0, 4, 8}) diagonal[entry] += model_.mass[row];
  }
}

void Elasticity::know_energies_at(const Points& x) {
  if (energies_.at.at(x)) return;
  energies_.membrane.clear(), energies_.bending.clear();
  energies_.at.set(x);
}

double Elasticity::membrane_energy(const Team& team, const Points& x) {
  const auto total = [&](std::vector<double>& sums) {
    if (divided()) gather_block_sums(*layout_, first_, sums);
    return std::accumulate(sums.begin(), sums.end(), 0.0);
  };
  if (membrane_.in_phase()) {
    std::vector<double> sums = membrane_sums(team, x);
    return total(sums);
  }
  know_energies_at(x);
  if (energies_.membrane.empty()) energies_.membrane = membrane_sums(team, x);
  return total(energies_.membrane);
}

std::vector<double> Elasticity::membrane_sums(const Team& team, const Points& x) {
  if (!divided()) return {membrane_.energy(team, x)};
  const auto block = [&](Index triangle) {
    return (triangle + rows_per_block - 1) / rows_per_block;
  };
  const int rank = layout_->communicator().rank();
  std::vector<double> sums(block(membrane_.n_triangles()), 0.0);
  membrane_.sum_energies(team, x, {block(first_[rank]), block(first_[rank + 1])}, sums);
  return sums;
}

double Elasticity::bending_energy(const Team& team, const Points& x) {
  know_energies_at(x);
  if (energies_.bending.empty()) energies_.bending = bending_sums(team, x);
  double energy = 0.0;
  auto sum = energies_.bending.begin();  // first sum of the next cloth
  for (const BendingElements& of_part : bending_) {
    std::vector<double> sums(sum, sum + n_sums(of_part));
    sum += n_sums(of_part);
    if (!of_part.first.empty()) gather_block_sums(*layout_, of_part.first, sums);
    energy += std::accumulate(sums.begin(), sums.end(), 0.0);
  }
  return energy;
}

std::vector<double> Elasticity::bending_sums(const Team& team, const Points& x) {
  std::vector<double> all;
  for (const BendingElements& of_part : bending_) {
    const std::size_t begin = all.size();
    all.resize(begin + n_sums(of_part), 0.0);
    if (of_part.first.empty()) {
      all[begin] = of_part.element->energy(team, x);
      continue;
    }
    const int rank = layout_->communicator().rank();
    of_part.element->sum_energies(team, x, of_part.triangles,
                                  all.data() + begin + of_part.first[rank] / rows_per_block);
  }
  return all;
}

void Elasticity::strain_of_rank(const Team& team, const Points& x, Points& green, Vector& stretch) {
  const int rank = divided() ? layout_->communicator().rank() : 0;
  const IndexRange own = divided() ? IndexRange{first_[rank], first_[rank + 1]}
                                   : IndexRange{0, membrane_.n_triangles()};
  membrane_.strain(team, x, own, green, stretch);
}

void Elasticity::strain(const Team& team, const Points& x, Points& green, Vector& stretch) {
  const Index m = membrane_.n_triangles();
  if (!divided()) return membrane_.strain(team, x, green, stretch);
  // Builds the elements of at most 16,384 triangles at a time, to save memory.
  constexpr Index at_once = 16384;
  green.resize(m, 3), stretch.resize(m);
  Points green_of_piece;
  Vector stretch_of_piece;
  for (Index first = 0; first < m; first += at_once) {
    const Index n = std::min(at_once, m - first);
    std::vector<MembraneConstants> constants;
    for (Index t = first; t < first + n; ++t) constants.push_back(model_.constants_of(t));
    Membrane membrane(model_.n_vertices, model_.triangles.middleRows(first, n),
                      model_.corners.range(first, first + n), constants);
    membrane.strain(team, x, green_of_piece, stretch_of_piece);
    green.middleRows(first, n) = green_of_piece;
    stretch.segment(first, n) = stretch_of_piece;
  }
}

std::size_t Elasticity::bending_bytes() const {
  std::size_t sum = bytes_of(zero_velocity_, known_.bending.force);
  for (const BendingElements& of_part : bending_) sum += of_part.element->bytes();
  return sum;
}

double recovery_rate(const ClothModel& cloth) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < cloth.constants.size(); ++i) {
    const Index vertices = cloth.first_vertex[i + 1] - cloth.first_vertex[i];
    const Index triangles = cloth.first_triangle[i + 1] - cloth.first_triangle[i];
    const double mass = cloth.mass.segment(cloth.first_vertex[i], vertices).sum() / triangles;
    const double modulus = std::min(cloth.constants[i].a11, cloth.constants[i].a22);
    least = std::min(least, std::sqrt(modulus / (2.0 * mass)));
  }
  return least;
}

}  // namespace loomstone
