#include "core/collision/near_lists.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace loomstone {

namespace {

// A list is made to last so many steps of the present motion, but reaches no farther than so many thicknesses. Our choice,
// tuned on a draped sheet; larger lists cost more tests a step, smaller ones are made more often.
constexpr double steps_to_last = 12.0;
constexpr double least_slack = 0.2, most_slack = 2.5;  // [thickness]
// Allowance for rounding of bounds that are summed over steps [m].
constexpr double rounding = 1e-12;

using RowBox = Eigen::RowVector3d;

double box_distance(const RowBox& low_a, const RowBox& high_a, const RowBox& low_b, const RowBox& high_b) {
  return (low_b - high_a).cwiseMax(low_a - high_b).cwiseMax(0.0).norm();
}

}  // namespace

std::vector<SurfaceMotion> surface_motions(const CollisionModel& model, const Points& x0, const Points& x1) {
  std::vector<SurfaceMotion> motions(model.surfaces.size());
  for (std::size_t s = 0; s < motions.size(); ++s) {
    const CollisionSurface& surface = model.surfaces[s];
    if (surface.n_vertices == 0) continue;
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    const double* a = x0.data() + 3 * static_cast<std::size_t>(surface.first_vertex);
    const double* b = x1.data() + 3 * static_cast<std::size_t>(surface.first_vertex);
    for (Index i = 0; i < surface.n_vertices; ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const double d = b[3 * i + axis] - a[3 * i + axis];
        low[axis] = std::min(low[axis], d);
        high[axis] = std::max(high[axis], d);
      }
    Vec3 half;
    for (int axis = 0; axis < 3; ++axis) {
      motions[s].centre[axis] = 0.5 * (low[axis] + high[axis]);
      half[axis] = 0.5 * (high[axis] - low[axis]);
    }
    motions[s].radius = half.norm();
  }
  return motions;
}

NearLists::NearLists(const CollisionModel& model, const std::vector<SurfacePair>& pairs, BroadPhase& broad_phase)
    : model_(model),
      pairs_(pairs),
      broad_phase_(broad_phase),
      lists_(pairs.size()),
      slack_(pairs.size(), -1.0),
      used_(pairs.size(), 0.0) {}

double NearLists::change_bound(Index i, const std::vector<SurfaceMotion>& motions) const {
  const SurfaceMotion &a = motions[pairs_[i].a], &b = motions[pairs_[i].b];
  return (a.radius + b.radius + (a.centre - b.centre).norm()) * (1.0 + 1e-12) + rounding;
}

bool NearLists::updated_at(const Points& x) const {
  return previous_.rows() == x.rows() && std::memcmp(previous_.data(), x.data(), sizeof(double) * x.size()) == 0;
}

bool NearLists::covers(Index i, const std::vector<SurfaceMotion>& motions) const {
  return used_[i] + change_bound(i, motions) <= slack_[i];
}

void NearLists::update(const Team& team, const Points& x) {
  const bool first = previous_.rows() != x.rows();
  std::vector<Index> stale;
  std::vector<double> reach(pairs_.size(), 0.0);
  std::vector<RowBox> low, high;
  const std::vector<SurfaceMotion> motions =
      first ? std::vector<SurfaceMotion>(model_.surfaces.size()) : surface_motions(model_, previous_, x);
  for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i) {
    const double change = change_bound(i, motions);
    used_[i] += change;
    // The negated comparison also catches motions that are not numbers.
    if (!first && used_[i] <= slack_[i]) continue;
    if (low.empty())
      for (const CollisionSurface& surface : model_.surfaces) {
        const auto rows = x.middleRows(surface.first_vertex, surface.n_vertices);
        low.push_back(surface.n_vertices ? RowBox(rows.colwise().minCoeff()) : RowBox::Zero());
        high.push_back(surface.n_vertices ? RowBox(rows.colwise().maxCoeff()) : RowBox::Zero());
      }
    const Index a = pairs_[i].a, b = pairs_[i].b;
    const double thickness = pairs_[i].thickness;
    double slack = std::clamp(steps_to_last * change, least_slack * thickness, most_slack * thickness);
    if (!(change < 0.5 * most_slack * thickness)) slack = least_slack * thickness;  // too fast for a list to last
    if (first) slack = thickness;
    used_[i] = 0.0;
    const double apart = a == b ? 0.0 : box_distance(low[a], high[a], low[b], high[b]) * (1.0 - 1e-12) - rounding;
    if (apart > thickness + slack) {
      lists_[i] = {};
      slack_[i] = apart - thickness;
      continue;
    }
    slack_[i] = slack;
    reach[i] = thickness + slack + rounding;
    stale.push_back(i);
  }
  previous_ = x;
  if (stale.empty()) return;
  std::vector<FeaturePairs> found;
  broad_phase_.near_pairs(team, x, stale, reach, found);
  for (const Index i : stale) {
    lists_[i].pairs = std::move(found[i]);
    lists_[i].vertex_face_distance.resize(lists_[i].pairs.vertex_face.size());
    lists_[i].edge_edge_distance.resize(lists_[i].pairs.edge_edge.size());
  }
}

}  // namespace loomstone
