#include "core/collision/certify/clean_up.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace loomstone {

namespace {

// Target gap of the first round of clean-up, as a fraction of the thickness. Our choice. Between
// cloth and bodies or obstacles, each further round multiplies the target by `next_target`, but not
// below twice CollisionModel::gap_floor, so that cloth fits into narrow gaps. Between cloth and
// cloth, the target is the same in all rounds. No target exceeds the larger of two distances: the
// distance of the pair at x0, and twice CollisionModel::gap_floor.
constexpr double target_gap = 0.2, next_target = 0.25;
constexpr int most_sweeps = 12;
// Tolerance of Impulses::solve(), relative to the target gap with which a contact was added.
constexpr double tolerance = 1e-3;

bool before(const ImpulseContact& a, const ImpulseContact& b) {
  return std::tie(a.kind, a.key) < std::tie(b.kind, b.key);
}

}  // namespace

void CleanUp::solve(const std::vector<StepImpact>& impacts, const Points& x0, Points& x1) {
  const int round = round_++;
  for (ImpulseContact& c : contacts_)
    if (!c.cloth_only && round > 0)
      c.target = std::max(next_target * c.target, std::min(c.target, 2.0 * model_.gap_floor));
  std::vector<ImpulseContact> added;
  for (const StepImpact& each : impacts) {
    ImpulseContact c;
    c.kind = each.kind;
    c.key = each.key;
    c.meet(each.vertices, each.impact.weights);
    c.normal = each.impact.normal;
    if (!impulses_.prepare(c, x0, x1, each.impact.time)) continue;
    Vec3 travel = Vec3::Zero();
    for (int i = 0; i < 4; ++i)
      travel += c.weights[i] * (x1.row(c.vertices[i]) - x0.row(c.vertices[i])).transpose();
    const SurfacePair& pair = pairs_[each.pair];
    const double least = std::min(target_gap * pair.thickness, 2.0 * model_.gap_floor);
    c.cloth_only = model_.surfaces[pair.b].kind == CollisionSurface::Kind::Cloth;
    const double asked = c.cloth_only ? target_gap : target_gap * std::pow(next_target, round);
    c.target = std::min(std::max(asked * pair.thickness, least),
                        std::max(each.impact.start_distance, 2.0 * model_.gap_floor));
    c.scale = c.target;
    c.largest_change = travel.norm() + pair.thickness;
    c.friction = pair.friction;
    added.push_back(c);
  }
  // If a pair collides again, its new linearisation replaces the earlier one. The corrections of
  // earlier rounds stay in x1.
  std::vector<ImpulseContact> merged;
  std::size_t i = 0, j = 0;
  while (i < contacts_.size() || j < added.size()) {
    if (j == added.size() || (i < contacts_.size() && before(contacts_[i], added[j]))) {
      merged.push_back(contacts_[i++]);
    } else {
      if (i < contacts_.size() && !before(added[j], contacts_[i])) ++i;
      merged.push_back(added[j++]);
    }
  }
  contacts_ = std::move(merged);
  impulses_.solve(contacts_, x0, x1, most_sweeps, tolerance);
}

}  // namespace loomstone
