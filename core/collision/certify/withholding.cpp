#include "core/collision/certify/withholding.h"

#include <algorithm>

#include "core/collision/certify/displacements.h"

namespace loomstone {

namespace {

// Units and carriers are defined in displacements.h. A unit keeps the fraction `share_of_time` of
// its relative motion up to the time of impact.
constexpr double share_of_time = 0.8;
// Number of passes that apply `share_of_time`. Later passes withhold all relative motion of
// colliding units.
constexpr int partial_passes = 8;
// Largest index of a pass, counted from 0. The number of passes is bounded, because impacts that
// cannot be resolved could recur forever.
constexpr int most_passes = 40;

// Joins the movable units of an impact to a common carrier. All their relative motion is already
// withheld, so the motion of carriers or of immovable vertices causes the impact. Units without a
// carrier follow the carrier of the first carried unit in impact.vertices or, if no unit is
// carried, the immovable vertices. If all units are carried, they follow the carrier of the first
// one. Returns false if nothing changes.
bool join_carriers(const StepImpact& impact, Displacements& displacements) {
  Index leader = -1;
  bool immovable_leads = false;
  for (const Index v : impact.vertices) {
    if (!displacements.movable(v))
      immovable_leads = true;
    else if (leader < 0 && displacements.carried(v))
      leader = v;
  }
  bool changed = false;
  for (const Index v : impact.vertices) {
    if (!displacements.movable(v) || displacements.carried(v)) continue;
    if (leader >= 0) {
      displacements.carry_with_vertex(v, leader);
      changed = true;
    } else if (immovable_leads) {
      displacements.carry_with_immovable(v, impact);
      changed |= displacements.carried(v);
    }
  }
  if (changed || leader < 0) return changed;
  for (const Index v : impact.vertices)
    if (displacements.movable(v) && v != leader && !displacements.same_carrier(v, leader)) {
      displacements.carry_with_vertex(v, leader);
      changed = true;
    }
  return changed;
}

// Withholds all motion of the movable units of an impact.
void withhold_units(const StepImpact& impact, Displacements& displacements) {
  for (const Index v : impact.vertices)
    if (displacements.movable(v)) displacements.withhold_all(displacements.unit(v));
}

// Last resort if impacts remain. Bodies and obstacles may then pass through cloth, but cloth must
// not pass through cloth. Withholds all motion of the movable vertices in impacts of cloth with
// cloth. Each pass leaves fewer moving vertices, so the loop ends. In the impacts of cloth with
// cloth that remain, only prescribed vertices move.
void keep_cloth_from_cloth(const Team& team, ImpactSearch& search, const MotionInputs& inputs,
                           const Points& x1, Displacements& displacements) {
  const CollisionModel& model = search.model();
  const auto cloth = [&](const StepImpact& impact) {
    for (const Index v : impact.vertices)
      if (model.surfaces[model.surface_of_vertex(v)].kind != CollisionSurface::Kind::Cloth)
        return false;
    return true;
  };
  displacements.take_changed();
  std::vector<StepImpact> impacts = search.find(team, inputs, x1, nullptr);
  for (;;) {
    for (const StepImpact& each : impacts)
      if (cloth(each)) withhold_units(each, displacements);
    const std::vector<std::uint8_t> changed = displacements.take_changed();
    if (std::find(changed.begin(), changed.end(), 1) == changed.end()) return;
    impacts = search.find(team, inputs, x1, &changed);
  }
}

}  // namespace

CertifyReport withhold_motion(const Team& team, ImpactSearch& search, const MotionInputs& inputs,
                              std::vector<StepImpact> impacts, Points& x1, FreeBodies& bodies) {
  CertifyReport report;
  if (impacts.empty()) return report;
  Displacements displacements(search.model(), inputs.x0, inputs.inverse_mass, x1, bodies);
  std::vector<double> factor(inputs.x0.rows());
  for (int pass = 0; !impacts.empty(); ++pass) {
    const bool withhold_all = pass >= partial_passes;
    std::vector<Index> touched;  // colliding units
    std::fill(factor.begin(), factor.end(), 2.0);
    bool progress = false;
    for (const StepImpact& each : impacts) {
      bool any_share = false;
      bool any_immovable = false;
      for (const Index v : each.vertices) any_immovable |= !displacements.movable(v);
      for (const Index v : each.vertices) {
        if (!displacements.movable(v)) continue;
        const Index unit = displacements.unit(v);
        if (any_immovable) displacements.carry_with_immovable(v, each);
        if (displacements.share(v) > 0.0) any_share = true;
        if (factor[unit] == 2.0) touched.push_back(unit);
        factor[unit] =
            std::min(factor[unit], withhold_all ? 0.0 : share_of_time * each.impact.time);
      }
      if (!any_share) progress |= join_carriers(each, displacements);
    }
    for (const Index unit : touched) {
      if (displacements.share(unit) > 0.0) progress = true;
      displacements.withhold(unit, factor[unit]);
    }
    const std::vector<std::uint8_t> changed = displacements.take_changed();
    progress |= std::find(changed.begin(), changed.end(), 1) != changed.end();
    if (progress) impacts = search.find(team, inputs, x1, &changed);
    // The search above omits impacts without a changed vertex. Only a full search proves that no
    // impact is left.
    if (!progress || impacts.empty() || pass >= most_passes)
      impacts = search.find(team, inputs, x1, nullptr);
    if (!progress || pass >= most_passes) {
      report.unresolved = static_cast<std::int64_t>(impacts.size());
      if (report.unresolved > 0) keep_cloth_from_cloth(team, search, inputs, x1, displacements);
      break;
    }
  }
  displacements.finish();
  report.withheld = displacements.withheld();
  return report;
}

}  // namespace loomstone
