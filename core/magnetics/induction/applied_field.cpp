#include "core/magnetics/induction/applied_field.h"

#include <algorithm>
#include <cassert>

#include "core/magnetics/sources/charged_panels.h"
#include "core/magnetics/sources/gauss.h"

namespace loomstone {

namespace {

constexpr int order = 3, per_leaf = AppliedField::points;
static_assert(order * order == per_leaf);
// If there are at least this many leaves, no further round of bisection starts. With this limit,
// the relative error of the force between a block magnet and a plate is at most 1e-3 if the block
// is rotated by 17 or 45 degrees about the normal of the plate (docs/experiments/magnetics.md).
constexpr std::size_t most_leaves = 4000;
// Panels and leaves are bisected if their error is at least this fraction of the largest error.
constexpr double worst = 0.1;

struct Judged {
  double error[2] = {0.0, 0.0};  // estimated quadrature errors of (B.n) B in u and in v [T^2 m^2]
  double size = 0.0;             // integral of (B.n)^2 [T^2 m^2]
  double whole() const { return error[0] + error[1]; }
};

// Returns the estimated error of the three-point rule in one direction of a panel. `sums` contains
// the integrand at the three points, integrated over the other direction. The rule is exact up to
// degree 5, so its error is about the Legendre coefficient of degree 6. This coefficient is
// estimated from the coefficient of degree 2 and the largest of those of degrees 0 to 2, by
// assuming geometric decay.
double panel_rule_error(const Vec3* sums) {
  const GaussRule& rule = gauss_rule(order);
  double largest = 0.0, last = 0.0;
  for (int degree = 0; degree < order; ++degree) {
    Vec3 coefficient = Vec3::Zero();
    for (int i = 0; i < order; ++i) coefficient += rule.legendre[degree * order + i] * sums[i];
    last = (degree + 0.5) * coefficient.norm();
    largest = std::max(largest, last);
  }
  return largest > 0.0 ? last * last * last / (largest * largest) : 0.0;
}

// Returns the estimated errors and the integral of (B.n)^2 on a panel with the unit normal
// `direction`. `areas` are the areas that the points of the panel represent [m^2]. `field` is B at
// the points, row by row, in the axes of the body [T]. `normal` receives B.n at the points [T].
Judged judge(const Vec3& direction, const double* areas, const double* field, double* normal) {
  Vec3 along_u[order], along_v[order];
  for (int i = 0; i < order; ++i) along_u[i] = along_v[i] = Vec3::Zero();
  const GaussRule& rule = gauss_rule(order);
  Judged judged;
  for (int i = 0; i < order; ++i) {
    for (int k = 0; k < order; ++k) {
      const int at = i * order + k;
      const Eigen::Map<const Vec3> b(field + 3 * at);
      normal[at] = direction.dot(b);
      const Vec3 stress = areas[at] * normal[at] * b;
      along_u[i] += 2.0 / rule.weights[i] * stress;
      along_v[k] += 2.0 / rule.weights[k] * stress;
      judged.size += areas[at] * normal[at] * normal[at];
    }
  }
  judged.error[0] = panel_rule_error(along_u);
  judged.error[1] = panel_rule_error(along_v);
  return judged;
}

// Bisects a triangle at its longest edge, or a rectangle in the direction of u (`along_u`) or v.
std::pair<FlatPanel, FlatPanel> halves(const FlatPanel& panel, bool along_u) {
  const Vec3* x = panel.corner;
  if (panel.corners == 4) {
    const int first = along_u ? 0 : 1;
    const Vec3 &a = x[first], &b = x[first + 1], &c = x[first + 2], &d = x[(first + 3) % 4];
    const Vec3 low = 0.5 * (a + b), high = 0.5 * (c + d);
    const Vec3 one[4] = {a, low, high, d}, other[4] = {low, b, c, high};
    return {make_panel(one, 4), make_panel(other, 4)};
  }
  int longest = 0;
  const auto length = [&](int k) { return (x[(k + 1) % 3] - x[k]).squaredNorm(); };
  for (int k = 1; k < 3; ++k)
    if (length(k) > length(longest)) longest = k;
  const Vec3 &a = x[longest], &b = x[(longest + 1) % 3], &c = x[(longest + 2) % 3],
             middle = 0.5 * (a + b);
  const Vec3 one[3] = {a, middle, c}, other[3] = {middle, b, c};
  return {make_panel(one, 3), make_panel(other, 3)};
}

// Adaptive bisection of the panels of a body.
class Refinement {
 public:
  Refinement(const Team& team, const PanelSet& set, const AppliedSources& sources)
      : team_(team),
        set_(set),
        sources_(sources),
        rotation_(rotation_matrix(sources.pose.orientation)) {}

  AppliedField run(double tolerance) {
    judge_panels();
    while (result_.leaves.size() < most_leaves) {
      double error = 0.0, size = 0.0, largest = 0.0;
      for (const std::vector<Judged>* all : {&panels_, &leaves_}) {
        for (const Judged& judged : *all) {
          error += judged.whole();
          largest = std::max(largest, judged.whole());
          size += judged.size;
        }
      }
      if (!(error > tolerance * size)) break;
      fresh_.clear();
      halve_leaves(worst * largest);
      halve_panels(worst * largest);
      judge_fresh();
    }
    for (const AppliedField::Leaf& leaf : result_.leaves)
      for (int k = 0; k < per_leaf; ++k)
        result_.fluxes[leaf.parent] += leaf.areas[k] * leaf.normal[k];
    return std::move(result_);
  }

 private:
  Points field_at(const Points& local) const {  // points and field in the body's axes
    Points world(local.rows(), 3);
    place_points(sources_.pose, local, world);
    Points b = magnetic_field(team_, sources_.by, world, "B");
    for (Eigen::Index i = 0; i < b.rows(); ++i)
      b.row(i) = (b.row(i) + sources_.uniform.transpose()).eval() * rotation_;
    return b;
  }

  void judge_panels() {
    const std::size_t n = set_.panels.size();
    assert(set_.per_panel == per_leaf && "samples are those of the rule here");
    result_.halved.assign(n, 0);
    result_.normal.resize(set_.samples.rows());
    result_.fluxes = Vector::Zero(static_cast<Eigen::Index>(n));
    panels_.resize(n);
    const Points b = field_at(set_.samples);
    for (std::size_t p = 0; p < n; ++p) {
      const auto first = static_cast<Eigen::Index>(p * per_leaf);
      double areas[per_leaf];
      for (int k = 0; k < per_leaf; ++k) areas[k] = set_.shares[first + k] * set_.panels[p].area;
      panels_[p] =
          judge(set_.panels[p].normal, areas, b.row(first).data(), result_.normal.data() + first);
      for (int k = 0; k < per_leaf; ++k) result_.fluxes[p] += areas[k] * result_.normal[first + k];
    }
  }

  void place(const FlatPanel& panel, std::size_t at) {
    result_.leaves[at].panel = panel;
    int k = 0;
    for (const PanelPoint& point : panel_points(panel, order)) {
      result_.leaves[at].positions[k] = point.position;
      result_.leaves[at].areas[k++] = point.share * panel.area;
    }
    fresh_.push_back(at);
  }

  void add(const FlatPanel& panel, Index parent) {
    result_.leaves.emplace_back().parent = parent;
    leaves_.emplace_back();
    place(panel, leaves_.size() - 1);
  }

  void halve_leaves(double allowed) {
    for (std::size_t i = 0, count = leaves_.size(); i < count; ++i) {
      if (leaves_[i].whole() < allowed) continue;
      const auto [one, other] =
          halves(result_.leaves[i].panel, leaves_[i].error[0] >= leaves_[i].error[1]);
      place(one, i);
      add(other, result_.leaves[i].parent);
    }
  }

  void halve_panels(double allowed) {
    for (std::size_t p = 0; p < panels_.size(); ++p) {
      if (result_.halved[p] || panels_[p].whole() < allowed) continue;
      const auto [one, other] = halves(set_.panels[p], panels_[p].error[0] >= panels_[p].error[1]);
      panels_[p] = Judged();
      result_.halved[p] = 1;
      result_.fluxes[p] = 0.0;
      add(one, static_cast<Index>(p));
      add(other, static_cast<Index>(p));
    }
  }

  void judge_fresh() {
    Points local(fresh_.size() * per_leaf, 3);
    Eigen::Index row = 0;
    for (const std::size_t i : fresh_)
      for (const Vec3& x : result_.leaves[i].positions) local.row(row++) = x.transpose();
    const Points there = field_at(local);
    row = 0;
    for (const std::size_t i : fresh_) {
      AppliedField::Leaf& leaf = result_.leaves[i];
      leaves_[i] = judge(leaf.panel.normal, leaf.areas, there.row(row).data(), leaf.normal);
      row += per_leaf;
    }
  }

  const Team& team_;
  const PanelSet& set_;
  const AppliedSources& sources_;
  Mat3 rotation_;
  AppliedField result_;
  std::vector<Judged> panels_, leaves_;  // estimates for each panel and each leaf
  std::vector<std::size_t> fresh_;       // indices of leaves without an estimate
};

}  // namespace

AppliedField applied_field(const Team& team, const PanelSet& set, const AppliedSources& sources,
                           double tolerance) {
  return Refinement(team, set, sources).run(tolerance);
}

}  // namespace loomstone
