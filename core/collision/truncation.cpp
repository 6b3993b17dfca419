#include "core/collision/truncation.h"

#include <algorithm>
#include <cmath>

#include "core/collision/rigid_motion.h"

namespace loomstone {

namespace {

constexpr double share_of_time = 0.8;   // of the time of impact that a displacement keeps
constexpr int passes_before_freezing = 8;
constexpr int most_passes = 400;        // never reached in what was tried; beyond it the rest is reported as unresolved
constexpr Index none = -1, local = -2;  // carried by nothing; carried by a displacement of its own

// x1 = x0 + carry + share (displacement - carry)
class Displacements {
 public:
  Displacements(const CollisionModel& model, const Points& x0, const Vector& inverse_mass, Points& x1)
      : model_(model),
        x0_(x0),
        x1_(x1),
        inverse_mass_(inverse_mass),
        wanted_(x1 - x0),
        carry_(Points::Zero(x0.rows(), 3)),
        share_(x0.rows(), 1.0),
        carrier_(x0.rows(), none),
        changed_(x0.rows(), 0),
        motions_(model.surfaces.size()),
        known_(model.surfaces.size(), 0) {}

  bool movable(Index v) const { return inverse_mass_[v] > 0.0; }
  double share(Index v) const { return share_[v]; }
  bool carried(Index v) const { return carrier_[v] != none; }

  // Makes `v` follow the surface that vertex `by` of an impact belongs to.
  void carry_with_immovable(Index v, const StepImpact& impact) {
    if (carried(v)) return;
    double total = 0.0;
    Vec3 motion = Vec3::Zero();
    for (int i = 0; i < 4; ++i) {
      const Index u = impact.vertices[i];
      if (movable(u)) continue;
      const double weight = std::abs(impact.impact.weights[i]) + 1e-3;
      motion += weight * wanted_.row(u).transpose();
      total += weight;
      const Index s = model_.surface_of_vertex[u];
      if (model_.surfaces[s].kind == CollisionSurface::Kind::Cloth) continue;
      if (!known_[s]) {
        motions_[s] = rigid_motion(model_, s, x0_, x1_);
        known_[s] = 1;
      }
      if (motions_[s].rigid) {
        set_carrier(v, s, motions_[s].displacement(x0_.row(v).transpose()));
        return;
      }
    }
    set_carrier(v, local, motion / total);
  }

  void carry_with_vertex(Index v, Index other) {
    const Index s = carrier_[other];
    set_carrier(v, s, s >= 0 ? motions_[s].displacement(x0_.row(v).transpose()) : Vec3(carry_.row(other).transpose()));
  }

  bool same_carrier(Index v, Index other) const {
    return carrier_[v] == carrier_[other] && (carrier_[v] >= 0 || carry_.row(v) == carry_.row(other));
  }

  void shorten(Index v, double factor) {
    share_[v] *= factor;
    if (share_[v] < 1e-3) share_[v] = 0.0;
    apply(v);
  }

  std::vector<std::uint8_t> take_changed() {
    std::vector<std::uint8_t> changed(changed_.size(), 0);
    std::swap(changed, changed_);
    return changed;
  }

 private:
  void set_carrier(Index v, Index carrier, const Vec3& motion) {
    if (carrier == local && motion.isZero(0.0)) return;
    if (carrier >= 0 && motions_[carrier].rotation.isIdentity(0.0) && motions_[carrier].to == motions_[carrier].from) return;
    carrier_[v] = carrier;
    carry_.row(v) = motion.transpose();
    apply(v);
  }
  void apply(Index v) {
    const Eigen::RowVector3d x = x0_.row(v) + carry_.row(v) + share_[v] * (wanted_.row(v) - carry_.row(v));
    if (x == x1_.row(v)) return;
    x1_.row(v) = x;
    changed_[v] = 1;
  }

  const CollisionModel& model_;
  const Points& x0_;
  Points& x1_;
  const Vector& inverse_mass_;
  Points wanted_, carry_;
  std::vector<double> share_;
  std::vector<Index> carrier_;
  std::vector<std::uint8_t> changed_;
  std::vector<RigidMotion> motions_;
  std::vector<std::uint8_t> known_;
};

// Vertices of an impact that are frozen already and still collide can only differ in what carries them: those that are not
// carried join, those that are carried by different things follow the first. False where nothing is left to do.
bool join_carriers(const StepImpact& impact, Displacements& displacements) {
  Index leader = none;
  bool immovable_leads = false;
  for (const Index v : impact.vertices) {
    if (!displacements.movable(v)) immovable_leads = true;
    else if (leader == none && displacements.carried(v)) leader = v;
  }
  bool changed = false;
  for (const Index v : impact.vertices) {
    if (!displacements.movable(v) || displacements.carried(v)) continue;
    if (leader != none) {
      displacements.carry_with_vertex(v, leader);
      changed = true;
    } else if (immovable_leads) {
      displacements.carry_with_immovable(v, impact);
      changed |= displacements.carried(v);
    }
  }
  if (changed || leader == none) return changed;
  for (const Index v : impact.vertices)
    if (displacements.movable(v) && v != leader && !displacements.same_carrier(v, leader)) {
      displacements.carry_with_vertex(v, leader);
      changed = true;
    }
  return changed;
}

}  // namespace

CertifyReport truncate(const Team& team, const CollisionModel& model, ImpactSearch& search, const Points& x0,
                       const Vector& inverse_mass, std::vector<StepImpact> impacts, Points& x1) {
  CertifyReport report;
  if (impacts.empty()) return report;
  const Points given = x1;
  Displacements displacements(model, x0, inverse_mass, x1);
  std::vector<double> factor(x0.rows());
  std::vector<std::uint8_t> truncated(x0.rows(), 0), frozen(x0.rows(), 0);
  for (int pass = 0; !impacts.empty(); ++pass) {
    const bool freezing = pass >= passes_before_freezing;
    std::vector<Index> touched;
    std::fill(factor.begin(), factor.end(), 2.0);
    bool progress = false;
    for (const StepImpact& each : impacts) {
      bool any_share = false;
      bool any_immovable = false;
      for (const Index v : each.vertices) any_immovable |= !displacements.movable(v);
      for (const Index v : each.vertices) {
        if (!displacements.movable(v)) continue;
        if (any_immovable) displacements.carry_with_immovable(v, each);
        if (displacements.share(v) > 0.0) any_share = true;
        if (factor[v] == 2.0) touched.push_back(v);
        factor[v] = std::min(factor[v], freezing ? 0.0 : share_of_time * each.impact.time);
      }
      if (!any_share) progress |= join_carriers(each, displacements);
    }
    for (const Index v : touched) {
      if (displacements.share(v) > 0.0) progress = true;
      displacements.shorten(v, factor[v]);
      truncated[v] = 1;
      if (displacements.share(v) == 0.0) frozen[v] = 1;
    }
    const std::vector<std::uint8_t> changed = displacements.take_changed();
    progress |= std::find(changed.begin(), changed.end(), 1) != changed.end();
    if (!progress || pass >= most_passes) {
      report.unresolved = static_cast<std::int64_t>(impacts.size());
      break;
    }
    impacts = search.find(team, x0, x1, inverse_mass, &changed);
  }
  double withheld = 0.0, total = 0.0;
  for (Index v = 0; v < x0.rows(); ++v) {
    report.truncated += truncated[v];
    report.frozen += frozen[v];
    if (inverse_mass[v] <= 0.0) continue;
    withheld += (x1.row(v) - given.row(v)).norm();
    total += (given.row(v) - x0.row(v)).norm();
  }
  report.withheld = total > 0.0 ? withheld / total : 0.0;
  return report;
}

}  // namespace loomstone
