#include "core/integration/asynchronous/limit_impulses.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

namespace {

// Ratio of two bounds on strain: the present strain beyond which positions are corrected, divided
// by the predicted strain beyond which velocities are corrected. If Asynchronous::present is given,
// it replaces the upper bounds of the present strain that follow from this ratio. In
// [Thomaszewski2010], the two bounds are 0.10 and 0.075.
constexpr double present_ratio = 4.0 / 3.0;

LimitedCloth limited_cloth(const ClothModel& model) {
  return {model.n_vertices,      model.triangles, model.corners.all(), model.strain_limits,
          model.strain_limit_of, model.mass,      model.prescribed};
}

// Returns the bounds of a limit; if `edges` is true, high[0] bounds the strain of edges. If `bound`
// is given, it replaces all finite upper bounds. The other bounds are multiplied by `scale`.
// Without shear_min, the bounds of shear are symmetric: the lower one is minus the upper one.
limit::Bounds bounds_of(const StrainLimit& limit, bool edges, std::optional<double> bound,
                        double scale) {
  const auto most = [&](double e) { return std::isfinite(e) ? bound.value_or(scale * e) : e; };
  if (edges) return {{}, {most(limit.edge_bound()), 0.0, 0.0}};
  const double shear = most(limit.shear);
  return {{scale * limit.weft_min, scale * limit.warp_min,
           limit.shear_min ? scale * *limit.shear_min : -shear},
          {most(limit.weft), most(limit.warp), shear}};
}

}  // namespace

LimitImpulses::LimitImpulses(const ClothModel& model, const Asynchronous& options)
    : model_(model),
      elements_(limited_cloth(model), true),
      slot_of_(model.triangles.rows(), -1),
      exceeds_(model.triangles.rows(), 0) {
  for (std::size_t slot = 0; slot < 8 * static_cast<std::size_t>(elements_.n_batches()); ++slot)
    if (const Index t = elements_.element(static_cast<Index>(slot)); t >= 0)
      slot_of_[t] = static_cast<Index>(slot);
  std::optional<double> present = options.present;
  if (!present && options.predicted) present = present_ratio * *options.predicted;
  for (const StrainLimit& limit : model.strain_limits) {
    const bool edges = model.limited_by_edges || limit.edge.has_value();
    by_edges_.push_back(edges);
    predicted_.push_back(bounds_of(limit, edges, options.predicted, 1.0));
    present_.push_back(bounds_of(limit, edges, present, present_ratio));
  }
}

bool LimitImpulses::limit_edges(Index triangle, double longest, Corners& x) const {
  bool any = false;
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const Index a = model_.triangles(triangle, k), b = model_.triangles(triangle, next);
    const double wa = model_.prescribed[a] ? 0.0 : 1.0 / model_.mass[a],
                 wb = model_.prescribed[b] ? 0.0 : 1.0 / model_.mass[b];
    Eigen::Map<Vec3> xa(x + 3 * static_cast<std::size_t>(k)),
        xb(x + 3 * static_cast<std::size_t>(next));
    const Corners2& rest = elements_.rest_corners(triangle);
    const Vec3 d = xb - xa;
    const double length = d.norm(),
                 excess = length - (1.0 + longest) * (rest.row(next) - rest.row(k)).norm();
    if (excess <= 0.0 || wa + wb == 0.0) continue;
    const Vec3 shift = excess / (length * (wa + wb)) * d;
    xa += wa * shift;
    xb -= wb * shift;
    any = true;
  }
  return any;
}

bool LimitImpulses::limit(Index triangle, const std::vector<limit::Bounds>& bounds,
                          Corners& x) const {
  const Index slot = slot_of_[triangle];
  const Index row = model_.strain_limit_of[triangle];
  if (by_edges_[row]) return limit_edges(triangle, bounds[row].high[0], x);
  // Tables that contain only this triangle. Its corners are rows 0, 1 and 2 of x.
  static constexpr Index corners[24] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 2};
  static constexpr Index only = 0;
  const limit::Tables all = elements_.tables();
  const limit::Tables own{corners,
                          nullptr,
                          nullptr,
                          all.moves + slot,
                          &only,
                          bounds.data() + row,
                          all.rows + limit::element_numbers * static_cast<std::size_t>(slot)};
  return limit::correct_one(own, {x, nullptr, 0.0}, 0);
}

namespace {
template <class Rows>
void get_corners(const Triangles& triangles, Index t, const Rows& rows, double* x) {
  for (int k = 0; k < 3; ++k) Eigen::Map<Vec3>(x + 3 * k) = rows.row(triangles(t, k)).transpose();
}
}  // namespace

bool LimitImpulses::exceeds(Index triangle, double step, const Points& x, const Points& v) const {
  if (slot_of_[triangle] < 0) return false;
  Corners now, rate, next;
  get_corners(model_.triangles, triangle, x, now);
  get_corners(model_.triangles, triangle, v, rate);
  for (int i = 0; i < 9; ++i) next[i] = now[i] + step * rate[i];
  return limit(triangle, predicted_, next) || limit(triangle, present_, now);
}

void LimitImpulses::correct(Index triangle, double step, Points& x, Points& v) {
  if (slot_of_[triangle] < 0) return;
  Corners now, rate, next, limited;
  get_corners(model_.triangles, triangle, x, now);
  if (limit(triangle, present_, now))
    for (int k = 0; k < 3; ++k)
      x.row(model_.triangles(triangle, k)) = Eigen::Map<const Vec3>(now + 3 * k).transpose();
  get_corners(model_.triangles, triangle, v, rate);
  for (int i = 0; i < 9; ++i) next[i] = limited[i] = now[i] + step * rate[i];
  if (!limit(triangle, predicted_, limited)) return;
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < 3; ++d)
      v(model_.triangles(triangle, k), d) += (limited[3 * k + d] - next[3 * k + d]) / step;
}

void LimitImpulses::correct(const Team& team, const std::vector<Index>& triangles,
                            const Vector& steps, Points& x, Points& v) {
  parallel_for(team, static_cast<Index>(triangles.size()), [&](Index i) {
    exceeds_[triangles[i]] = exceeds(triangles[i], steps[triangles[i]], x, v);
  });
  for (const Index t : triangles)
    if (exceeds_[t]) correct(t, steps[t], x, v);
}

}  // namespace loomstone
