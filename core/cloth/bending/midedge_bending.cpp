// The mid-edge bending element. Each triangle has the energy 1/2 kappa^T W kappa. Here kappa =
// C (theta - rest) is the change of the triangle's curvature that hinges cause, where theta and
// rest contain the current angles and the rest angles of up to nine hinges. W accounts for the
// change that slopes at boundary edges cause. midedge::make_elements() computes C and W.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/base/simd.h"
#include "core/cloth/bending/bending.h"
#include "core/cloth/bending/bending_setup.h"
#include "core/cloth/bending/hinge_hessian.h"
#include "core/cloth/bending/hinge_kernels.h"
#include "core/cloth/bending/hinge_stiffness.h"
#include "core/cloth/bending/midedge_setup.h"

namespace loomstone {

namespace {

class MidedgeBending final : public Bending {
 public:
  explicit MidedgeBending(const BendingSetup& setup);

  const std::vector<Hinge>& hinges() const override { return hinges_.hinges(); }
  const std::vector<double>& rest_angles() const override { return hinges_.rest_angles(); }
  std::vector<std::pair<Index, Index>> couplings() const override {
    return assembler_.couplings(hinges_);
  }

  double energy(const Team& team, const Points& x) const override;
  void sum_energies(const Team& team, const Points& x, IndexRange triangles,
                    double* sums) const override;
  bool sums_by_triangle() const override { return true; }
  void add_forces(const Team& team, const Points& x, const Points& v, Index begin, Index end,
                  RowsOut force) const override;
  void add_stiffness(const Team& team, const Points& x, StiffnessScales scales, Index begin,
                     Index end, BlockMatrix& matrix) const override;
  void add_geometric_stiffness(const Team& team, const Points& x, double scale, Index begin,
                               Index end, BlockMatrix& matrix) const override;
  double largest_eigenvalue(const Vector& mass) const override;

  Index averaged_edges() const override { return n_averaged_; }
  Index degenerate_hinges(const Team& team, const Points& x) const override {
    hinges_.evaluate(team, all_of(hinges_.n_batches()), x, nullptr, true, values_);
    return hinges_.count_degenerate(values_);
  }
  std::size_t bytes() const override {
    return bytes_of(rest_positions_, prescribed_, hinges_, element_hinges_, curvature_, rigidity_,
                    slot_start_, slots_, elastic_, viscous_, assembler_, range_, values_) +
           bytes_of(selection_.hinges, selection_.triangle_batches, selection_.hinge_batches,
                    element_moments_, moment_, energy_, q_);
  }

 private:
  void build_tables(const BendingSetup& setup, const std::vector<midedge::Element>& elements);
  void build_pairs(const BendingSetup& setup, const std::vector<midedge::Element>& elements);
  void select_rows(Index begin, Index end) const;
  void find_moments(const Team& team, const double* rate) const;
  midedge::Tables tables() const {
    return {element_hinges_.data(), curvature_.data(), rigidity_.data()};
  }
  double hinge_moment(Index e) const {
    double sum = 0.0;
    for (Index k = slot_start_[e]; k < slot_start_[e + 1]; ++k) sum += element_moments_[slots_[k]];
    return sum;
  }

  Points rest_positions_;
  std::vector<std::uint8_t> prescribed_;
  HingeSet hinges_;
  Index n_triangles_ = 0, n_averaged_ = 0;
  bool damped_ = false;
  std::vector<Index> element_hinges_;  // layout: see hinge_kernels.h
  AlignedDoubles curvature_, rigidity_;
  // For each hinge, the entries of element_moments_ whose sum is the moment of the hinge, with
  // triangles in ascending order.
  std::vector<Index> slot_start_, slots_;
  // For each pair of hinges, the sums over all triangles of the pair's entry in C^T W C (see the
  // top of this file) and in beta C^T W C, where beta is the damping of the triangle [s]. In lumped
  // form, each hinge is paired only with itself, and the tables contain the numbers q_e of
  // BendingSetup::lumped_stiffness instead. viscous_ is empty without damping.
  AlignedDoubles elastic_, viscous_;

  // Scratch memory. The assembler also has constant tables of hinges and vertices.
  mutable HingeStiffness assembler_;
  mutable HingeRange range_;
  struct Selection {  // everything that the forces on rows [begin, end) depend on
    Index begin = -1, end = -1;
    std::vector<Index> hinges;            // hinges whose moments act on the rows
    std::vector<Index> triangle_batches;  // triangle batches that the moments of `hinges` need
    std::vector<Index> hinge_batches;     // hinge batches whose angles the moments of `hinges` need
  };
  mutable Selection selection_;
  mutable HingeValues values_;
  mutable AlignedDoubles element_moments_, moment_, energy_, q_;
};

MidedgeBending::MidedgeBending(const BendingSetup& setup)
    : prescribed_(setup.prescribed), n_triangles_(static_cast<Index>(setup.triangles.rows())) {
  if (setup.keeps_rest) rest_positions_ = setup.rest_positions;
  check_bending_setup(setup);
  const EdgeTable edges =
      edge_table(static_cast<Index>(setup.rest_positions.rows()), setup.triangles);
  hinges_ = make_hinge_set(setup, edges);
  const midedge::Elements made = midedge::make_elements(setup, edges, hinges_.hinges());
  n_averaged_ = made.n_averaged;
  for (const double beta : setup.damping) damped_ = damped_ || beta > 0.0;
  build_tables(setup, made.elements);
  if (!setup.forces_only) build_pairs(setup, made.elements);
}

void MidedgeBending::build_tables(const BendingSetup& setup,
                                  const std::vector<midedge::Element>& elements) {
  const std::size_t n_batches = (n_triangles_ + n_lanes - 1) / n_lanes;
  element_hinges_.assign(n_batches * midedge::hinge_stride, 0);
  curvature_.assign(n_batches * midedge::curvature_stride, 0.0);
  rigidity_.assign(n_batches * midedge::rigidity_stride, 0.0);
  element_moments_.assign(n_batches * midedge::hinge_stride, 0.0);
  slot_start_.assign(hinges_.n_hinges() + 1, 0);
  for (Index t = 0; t < n_triangles_; ++t) {
    const std::size_t batch = t / n_lanes, lane = t % n_lanes;
    const midedge::Element& element = elements[t];
    for (int s = 0; s < element.n_hinges; ++s) {
      element_hinges_[midedge::hinge_stride * batch + n_lanes * s + lane] = element.hinge[s];
      for (int c = 0; c < 3; ++c)
        curvature_[midedge::curvature_stride * batch + 24 * s + n_lanes * c + lane] =
            element.curvature[s][c];
      ++slot_start_[element.hinge[s] + 1];
    }
    const Mat3& w = element.rigidity;
    const double row[7] = {w(0, 0), w(0, 1), w(0, 2), w(1, 1), w(1, 2), w(2, 2), setup.damping[t]};
    for (int k = 0; k < 7; ++k)
      rigidity_[midedge::rigidity_stride * batch + n_lanes * k + lane] = row[k];
  }
  for (Index e = 0; e < hinges_.n_hinges(); ++e) slot_start_[e + 1] += slot_start_[e];
  slots_.resize(slot_start_.back());
  std::vector<Index> fill(slot_start_.begin(), slot_start_.end() - 1);
  for (Index t = 0; t < n_triangles_; ++t)
    for (int s = 0; s < elements[t].n_hinges; ++s)
      slots_[fill[elements[t].hinge[s]]++] =
          (t / n_lanes) * midedge::hinge_stride + n_lanes * s + t % n_lanes;
}

void MidedgeBending::build_pairs(const BendingSetup& setup,
                                 const std::vector<midedge::Element>& elements) {
  HingePairs pairs;
  pairs.start.push_back(0);
  std::map<Index, std::array<double, 2>> row;
  for (Index e = 0; e < hinges_.n_hinges(); ++e) {
    row.clear();
    for (Index k = slot_start_[e]; k < slot_start_[e + 1]; ++k) {
      const Index batch = slots_[k] / midedge::hinge_stride,
                  rest = slots_[k] % midedge::hinge_stride;
      const Index t = batch * n_lanes + rest % n_lanes;
      const midedge::Element& element = elements[t];
      const Vec3 moment = element.rigidity * element.curvature[rest / n_lanes];
      for (int s = 0; s < element.n_hinges; ++s) {
        const double q = moment.dot(element.curvature[s]);
        std::array<double, 2>& entry = row[element.hinge[s]];
        entry[0] += q, entry[1] += setup.damping[t] * q;
      }
    }
    if (setup.lumped_stiffness) {
      std::array<double, 2> sum{};
      for (const auto& [hinge, q] : row)
        sum[0] += 0.5 * std::abs(q[0]), sum[1] += 0.5 * std::abs(q[1]);
      row = {{e, sum}};
    }
    for (const auto& [hinge, q] : row) {
      pairs.hinge.push_back(hinge);
      elastic_.push_back(q[0]);
      if (damped_) viscous_.push_back(q[1]);
    }
    pairs.start.push_back(static_cast<Index>(pairs.hinge.size()));
  }
  assembler_ =
      HingeStiffness(static_cast<Index>(setup.prescribed.size()), hinges_, std::move(pairs));
}

// The force on a row depends on the moments of its hinges. A moment depends on the triangles whose
// curvature involves the hinge. The curvature of a triangle depends on up to nine hinge angles.
void MidedgeBending::select_rows(Index begin, Index end) const {
  Selection& s = selection_;
  if (begin == s.begin && end == s.end) return;
  s.begin = begin, s.end = end;
  s.hinges.clear(), s.triangle_batches.clear(), s.hinge_batches.clear();
  std::vector<std::uint8_t> triangle_batch(element_hinges_.size() / midedge::hinge_stride),
      batch(hinges_.n_batches());
  for (Index e = 0; e < hinges_.n_hinges(); ++e) {
    const auto& vertices = hinges_.hinges()[e].vertices;
    if (std::none_of(vertices.begin(), vertices.end(),
                     [&](Index v) { return v >= begin && v < end; }))
      continue;
    s.hinges.push_back(e);
    batch[e / n_lanes] = 1;
    for (Index k = slot_start_[e]; k < slot_start_[e + 1]; ++k)
      triangle_batch[slots_[k] / midedge::hinge_stride] = 1;
  }
  for (Index b = 0; b < static_cast<Index>(triangle_batch.size()); ++b) {
    if (!triangle_batch[b]) continue;
    s.triangle_batches.push_back(b);
    const Index* first =
        element_hinges_.data() + midedge::hinge_stride * static_cast<std::size_t>(b);
    std::for_each(first, first + midedge::hinge_stride, [&](Index e) { batch[e / n_lanes] = 1; });
  }
  for (Index b = 0; b < hinges_.n_batches(); ++b)
    if (batch[b]) s.hinge_batches.push_back(b);
}

double MidedgeBending::energy(const Team& team, const Points& x) const {
  std::vector<double> sums((n_triangles_ + rows_per_block - 1) / rows_per_block, 0.0);
  sum_energies(team, x, {0, n_triangles_}, sums.data());
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

void MidedgeBending::sum_energies(const Team& team, const Points& x, IndexRange triangles,
                                  double* sums) const {
  if (hinges_.n_hinges() == 0) return;
  // Evaluates all hinges, and their gradients too, so that forces at the same positions can reuse
  // these values.
  hinges_.evaluate(team, all_of(hinges_.n_batches()), x, nullptr, true, values_);
  const Index first_batch = triangles.begin / n_lanes;
  std::vector<Index> batches((triangles.end + n_lanes - 1) / n_lanes - first_batch);
  std::iota(batches.begin(), batches.end(), first_batch);
  energy_.resize(element_hinges_.size() / midedge::hinge_stride * n_lanes);
  parallel_ranges(team, static_cast<Index>(batches.size()), hinge::batches_per_range,
                  [&](Index first, Index last) {
                    midedge::energies(tables(), batches.data() + first, last - first,
                                      values_.difference.data(), energy_.data());
                  });
  for (Index t = triangles.begin; t < triangles.end;) {
    const Index end = std::min(triangles.end, t + rows_per_block);
    *sums++ = std::accumulate(energy_.begin() + t, energy_.begin() + end, 0.0);
    t = end;
  }
}

void MidedgeBending::add_forces(const Team& team, const Points& x, const Points& v, Index begin,
                                Index end, RowsOut force) const {
  if (hinges_.n_hinges() == 0) return;
  select_rows(begin, end);
  const Selection& s = selection_;
  hinges_.evaluate(team, s.hinge_batches, x, damped_ ? &v : nullptr, true, values_);
  find_moments(team, damped_ ? values_.rate.data() : nullptr);
  hinges_.find_range(begin, end, range_);
  hinges_.gather(team, values_, moment_, range_, force);
}

// Computes the moments of the selected hinges from values_ and from `rate`. A null `rate` means no
// damping.
void MidedgeBending::find_moments(const Team& team, const double* rate) const {
  const Selection& s = selection_;
  parallel_ranges(team, static_cast<Index>(s.triangle_batches.size()), hinge::batches_per_range,
                  [&](Index first, Index last) {
                    midedge::moments(tables(), s.triangle_batches.data() + first, last - first,
                                     values_.difference.data(), rate, element_moments_.data());
                  });
  moment_.resize(values_.difference.size());
  parallel_for(team, static_cast<Index>(s.hinges.size()),
               [&](Index k) { moment_[s.hinges[k]] = hinge_moment(s.hinges[k]); });
}

void MidedgeBending::add_geometric_stiffness(const Team& team, const Points& x, double scale,
                                             Index begin, Index end, BlockMatrix& matrix) const {
  if (hinges_.n_hinges() == 0) return;
  select_rows(begin, end);
  hinges_.evaluate(team, selection_.hinge_batches, x, nullptr, false, values_);
  find_moments(team, nullptr);
  add_hinge_hessians(team, {hinges_, moment_, scale}, x, begin, end, matrix);
}

void MidedgeBending::add_stiffness(const Team& team, const Points& x, StiffnessScales scales,
                                   Index begin, Index end, BlockMatrix& matrix) const {
  if (hinges_.n_hinges() == 0) return;
  select_rows(begin, end);
  // The selection includes every hinge that is paired with a hinge of rows [begin, end).
  hinges_.evaluate(team, selection_.hinge_batches, x, nullptr, true, values_);
  if (!damped_) {
    assembler_.add(team, {hinges_, values_, elastic_, scales.elastic}, begin, end, matrix);
    return;
  }
  q_.resize(elastic_.size());
  parallel_for(
      team, static_cast<Index>(q_.size()),
      [&](Index p) { q_[p] = scales.elastic * elastic_[p] + scales.viscous * viscous_[p]; },
      Index{1} << 14);
  assembler_.add(team, {hinges_, values_, q_, 1.0}, begin, end, matrix);
}

double MidedgeBending::largest_eigenvalue(const Vector& mass) const {
  if (hinges_.n_hinges() == 0) return 0.0;
  const std::vector<Index> batches = all_of((n_triangles_ + n_lanes - 1) / n_lanes);
  return power_iteration(hinges_, rest_positions_, prescribed_, mass,
                         [&](const HingeValues& values, AlignedDoubles& moment) {
                           midedge::moments(tables(), batches.data(),
                                            static_cast<Index>(batches.size()), values.rate.data(),
                                            nullptr, element_moments_.data());
                           moment.resize(values.rate.size());
                           for (Index e = 0; e < hinges_.n_hinges(); ++e)
                             moment[e] = hinge_moment(e);
                         });
}

}  // namespace

std::unique_ptr<Bending> make_midedge_bending(const BendingSetup& setup) {
  return std::make_unique<MidedgeBending>(setup);
}

}  // namespace loomstone
