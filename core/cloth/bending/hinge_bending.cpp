// The hinge element, which assigns an energy to the dihedral angle of each interior edge. Forces
// and rest angles follow [Bridson2003] with the stiffness k = 4 B for flexural rigidity B. The
// results of this element depend on the mesh and do not converge under refinement. Its effective
// rigidity is 0.8 B along the axes of regular grids, 0.88 to 0.96 B on smoothed irregular meshes
// (0.83 B in strips 6 elements wide), and 0.7 to 2.2 B at 45 degrees to a grid. Use the mid-edge
// element if the rigidity must be accurate.
//
// Departure from [Thomaszewski2010]: damping is proportional to stiffness, as in the mid-edge
// element. The coefficient of a hinge is beta V''(0) = beta c / 2, where beta is the damping [s], V
// the energy of the hinge, and c its stiffness. [Thomaszewski2010] uses the damping factor |e|, the
// length of the edge, which depends on the mesh.
#include <algorithm>
#include <cmath>

#include "core/cloth/bending/bending.h"
#include "core/cloth/bending/bending_setup.h"
#include "core/cloth/bending/hinge_hessian.h"
#include "core/cloth/bending/hinge_stiffness.h"

namespace loomstone {

namespace {

// Area of a triangle, length of one of its edges, and bending rigidity about that edge. The
// rigidity is kappa^T D kappa for a unit curvature kappa about the edge, or 0 if the triangle has
// no energy (see BendingSetup::acts).
struct EdgeOfTriangle {
  double area, length, rigidity;
};

EdgeOfTriangle edge_of_triangle(const BendingSetup& setup, const EdgeTable& edges, Index triangle,
                                Index edge) {
  int i = 0;
  while (edges.of_triangle[triangle][i] != edge) ++i;
  const Corners2& x = setup.corners[triangle];
  const Vec2 e = (x.row((i + 2) % 3) - x.row((i + 1) % 3)).transpose(),
             f = (x.row(i) - x.row((i + 1) % 3)).transpose();
  const double length = e.norm();
  const Vec2 n(e.y() / length, -e.x() / length);
  const Vec3 kappa(n.x() * n.x(), n.y() * n.y(), 2.0 * n.x() * n.y());
  return {0.5 * (e.x() * f.y() - e.y() * f.x()), length,
          setup.acts_on(triangle) ? kappa.dot(setup.rigidity[triangle] * kappa) : 0.0};
}

HingePairs diagonal_pairs(Index n) {
  HingePairs pairs{all_of(n + 1), all_of(n)};
  return pairs;
}

class HingeBending final : public Bending {
 public:
  explicit HingeBending(const BendingSetup& setup) : prescribed_(setup.prescribed) {
    if (setup.keeps_rest) rest_positions_ = setup.rest_positions;
    check_bending_setup(setup);
    const EdgeTable edges =
        edge_table(static_cast<Index>(setup.rest_positions.rows()), setup.triangles);
    hinges_ = make_hinge_set(setup, edges);
    for (const Hinge& h : hinges_.hinges()) {
      const EdgeOfTriangle a = edge_of_triangle(setup, edges, h.triangles[0], h.edge);
      const EdgeOfTriangle b = edge_of_triangle(setup, edges, h.triangles[1], h.edge);
      const double length = 0.5 * (a.length + b.length);
      // Stiffness of the hinge at edge e: c = k |e|^2 / (|N1| + |N2|) with k = 4 B. The length of a
      // normal N1 or N2 is twice the area of its triangle.
      const double c =
          4.0 * 0.5 * (a.rigidity + b.rigidity) * length * length / (2.0 * (a.area + b.area));
      const double beta = 0.5 * (setup.damping[h.triangles[0]] + setup.damping[h.triangles[1]]);
      stiffness_.push_back(c);
      damping_.push_back(0.5 * beta * c);
      damped_ = damped_ || damping_.back() > 0.0;
    }
    for (const double angle : hinges_.rest_angles())
      rest_half_sine_.push_back(std::sin(0.5 * angle));
    if (setup.forces_only) return;
    assembler_ = HingeStiffness(static_cast<Index>(setup.rest_positions.rows()), hinges_,
                                diagonal_pairs(hinges_.n_hinges()));
  }

  const std::vector<Hinge>& hinges() const override { return hinges_.hinges(); }
  const std::vector<double>& rest_angles() const override { return hinges_.rest_angles(); }
  std::vector<std::pair<Index, Index>> couplings() const override {
    return assembler_.couplings(hinges_);
  }

  double energy(const Team& team, const Points& x) const override {
    // Gradients are evaluated too, so that forces at the same positions can reuse these values.
    hinges_.evaluate(team, all_of(hinges_.n_batches()), x, nullptr, true, values_);
    return parallel_sum(team, hinges_.n_hinges(), [&](Index e) {
      // Energy of a hinge with the angle theta:
      //   V = c [2 cos(rest / 2) - 2 cos(theta / 2) - (theta - rest) sin(rest / 2)].
      // The difference of cosines is written as a product to be accurate for small angles.
      const double rest = hinges_.rest_angles()[e], difference = values_.difference[e];
      const double cosines =
          2.0 * std::sin(0.5 * rest + 0.25 * difference) * std::sin(0.25 * difference);
      return stiffness_[e] * (2.0 * cosines - difference * rest_half_sine_[e]);
    });
  }

  void sum_energies(const Team&, const Points&, IndexRange, double*) const override {
    throw Unsupported("hinges have no energies by triangle");
  }
  bool sums_by_triangle() const override { return false; }

  void add_forces(const Team& team, const Points& x, const Points& v, Index begin, Index end,
                  RowsOut force) const override {
    hinges_.find_range(begin, end, range_);
    const std::vector<Index>& batches = range_.batches;
    hinges_.evaluate(team, batches, x, damped_ ? &v : nullptr, true, values_);
    moment_.resize(values_.difference.size());
    parallel_for(team, static_cast<Index>(batches.size()), [&](Index b) {
      const Index last = std::min(hinges_.n_hinges(), 8 * batches[b] + 8);
      for (Index e = 8 * batches[b]; e < last; ++e) {
        moment_[e] = stiffness_[e] * (values_.half_sine[e] - rest_half_sine_[e]);
        if (damped_) moment_[e] += damping_[e] * values_.rate[e];
      }
    });
    hinges_.gather(team, values_, moment_, range_, force);
  }

  void add_stiffness(const Team& team, const Points& x, StiffnessScales scales, Index begin,
                     Index end, BlockMatrix& matrix) const override {
    hinges_.find_range(begin, end, range_);
    const std::vector<Index>& batches = range_.batches;
    hinges_.evaluate(team, batches, x, nullptr, true, values_);
    moment_.resize(values_.difference.size());
    // Second derivative of the energy, with the stiffness c: V'' = 1/2 c cos(theta / 2) >= 0.
    parallel_for(team, static_cast<Index>(batches.size()), [&](Index b) {
      const Index last = std::min(hinges_.n_hinges(), 8 * batches[b] + 8);
      for (Index e = 8 * batches[b]; e < last; ++e)
        moment_[e] = scales.elastic * 0.5 * stiffness_[e] * values_.half_cosine[e] +
                     scales.viscous * damping_[e];
    });
    assembler_.add(team, {hinges_, values_, moment_, 1.0}, begin, end, matrix);
  }

  void add_geometric_stiffness(const Team& team, const Points& x, double scale, Index begin,
                               Index end, BlockMatrix& matrix) const override {
    hinges_.find_range(begin, end, range_);
    const std::vector<Index>& batches = range_.batches;
    hinges_.evaluate(team, batches, x, nullptr, false, values_);
    moment_.resize(values_.difference.size());
    for (const Index b : batches)
      for (Index e = 8 * b; e < std::min(hinges_.n_hinges(), 8 * b + 8); ++e)
        moment_[e] = stiffness_[e] * (values_.half_sine[e] - rest_half_sine_[e]);
    add_hinge_hessians(team, {hinges_, moment_, scale}, x, begin, end, matrix);
  }

  double largest_eigenvalue(const Vector& mass) const override {
    return power_iteration(hinges_, rest_positions_, prescribed_, mass,
                           [&](const HingeValues& values, AlignedDoubles& moment) {
                             moment.resize(values.rate.size());
                             for (Index e = 0; e < hinges_.n_hinges(); ++e)
                               moment[e] = 0.5 * stiffness_[e] *
                                           std::cos(0.5 * hinges_.rest_angles()[e]) *
                                           values.rate[e];
                           });
  }

  Index averaged_edges() const override { return 0; }
  Index degenerate_hinges(const Team& team, const Points& x) const override {
    hinges_.evaluate(team, all_of(hinges_.n_batches()), x, nullptr, true, values_);
    return hinges_.count_degenerate(values_);
  }
  std::size_t bytes() const override {
    return bytes_of(rest_positions_, prescribed_, hinges_, stiffness_, damping_, rest_half_sine_,
                    assembler_, range_, values_, moment_);
  }

 private:
  Points rest_positions_;
  std::vector<std::uint8_t> prescribed_;
  HingeSet hinges_;
  std::vector<double> stiffness_;       // c [N m]
  std::vector<double> damping_;         // damping coefficient beta c / 2 [N m s]
  std::vector<double> rest_half_sine_;  // sin(rest / 2)
  bool damped_ = false;

  // Scratch memory. The assembler also has constant tables of hinges and vertices.
  mutable HingeStiffness assembler_;
  mutable HingeRange range_;
  mutable HingeValues values_;
  mutable AlignedDoubles moment_;
};

}  // namespace

std::unique_ptr<Bending> make_hinge_bending(const BendingSetup& setup) {
  return std::make_unique<HingeBending>(setup);
}

}  // namespace loomstone
