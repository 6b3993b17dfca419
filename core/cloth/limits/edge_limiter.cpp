#include "core/cloth/limits/edge_limiter.h"

#include <algorithm>
#include <numeric>

#include "core/cloth/limits/strain_limiter.h"

namespace loomstone {

EdgeLimiter::EdgeLimiter(const LimitedCloth& cloth) {
  // An edge of a triangle, with its rest length [m] and the bound on its strain. An edge of two
  // limited triangles gets the mean of its rest lengths in them and the tighter of their bounds.
  struct Side {
    Index a, b;
    double length, bound;
  };
  std::vector<Side> sides;
  for (Index t = 0; t < cloth.triangles.rows(); ++t) {
    if (cloth.limit_of[t] < 0) continue;
    for (int k = 0; k < 3; ++k) {
      const Index a = cloth.triangles(t, k), b = cloth.triangles(t, (k + 1) % 3);
      const double length = (cloth.corners[t].row(k) - cloth.corners[t].row((k + 1) % 3)).norm();
      sides.push_back(
          {std::min(a, b), std::max(a, b), length, cloth.limits[cloth.limit_of[t]].edge_bound()});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
    return std::pair(p.a, p.b) < std::pair(q.a, q.b);
  });
  std::vector<Side> unique;
  for (const Side& side : sides) {
    if (!unique.empty() && unique.back().a == side.a && unique.back().b == side.b)
      unique.back().length = 0.5 * (unique.back().length + side.length),
      unique.back().bound = std::min(unique.back().bound, side.bound);
    else
      unique.push_back(side);
  }
  const Index n = static_cast<Index>(unique.size());
  Edges rows(n, 2);
  for (Index i = 0; i < n; ++i) rows.row(i) << unique[i].a, unique[i].b;
  Index n_colours = 0;
  const std::vector<Index> colour = colours(cloth.n_vertices, rows, n_colours);
  std::vector<Index> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return colour[a] < colour[b]; });
  edges_.resize(n, 2), longest_.resize(n), rest_.resize(n);
  colour_start_.assign(n_colours + 1, 0);
  edge_start_.assign(cloth.n_vertices + 1, 0);
  for (Index i = 0; i < n; ++i) {
    const Side& side = unique[order[i]];
    edges_.row(i) << side.a, side.b;
    rest_[i] = side.length, longest_[i] = side.length * (1.0 + side.bound);
    ++colour_start_[colour[order[i]] + 1];
    ++edge_start_[side.a + 1], ++edge_start_[side.b + 1];
  }
  std::partial_sum(colour_start_.begin(), colour_start_.end(), colour_start_.begin());
  std::partial_sum(edge_start_.begin(), edge_start_.end(), edge_start_.begin());
  edges_of_.resize(2 * static_cast<std::size_t>(n));
  std::vector<Index> fill(edge_start_.begin(), edge_start_.end() - 1);
  for (Index i = 0; i < n; ++i)
    for (int k = 0; k < 2; ++k) edges_of_[fill[edges_(i, k)]++] = i;
  inverse_mass_ = cloth.mass.cwiseInverse();
  for (Index v = 0; v < cloth.n_vertices; ++v)
    if (cloth.prescribed[v]) inverse_mass_[v] = 0.0;
}

LimitReport EdgeLimiter::enforce(const Team& team, const LimitOptions& options,
                                 const std::vector<Index>& held, Points& x) const {
  Vector inverse_mass = inverse_mass_;
  for (const Index v : held) inverse_mass[v] = 0.0;
  const Index n = static_cast<Index>(edges_.rows()),
              n_colours = static_cast<Index>(colour_start_.size()) - 1;
  std::vector<std::vector<Index>> active(n_colours);
  for (Index c = 0; c < n_colours; ++c) {
    active[c].resize(colour_start_[c + 1] - colour_start_[c]);
    std::iota(active[c].begin(), active[c].end(), colour_start_[c]);
  }
  std::vector<std::uint8_t> corrected(n, 0), in(n, 0), spread(n, 0);
  // Shortens an edge whose excess is above the tolerance. Both ends move along the edge, in
  // proportion to their inverse masses. If both are free, this conserves linear and angular
  // momentum.
  const auto correct = [&](Index e) {
    const Index a = edges_(e, 0), b = edges_(e, 1);
    const double wa = inverse_mass[a], wb = inverse_mass[b];
    const Vec3 d = (x.row(b) - x.row(a)).transpose();
    const double length = d.norm();
    corrected[e] = wa + wb > 0.0 && length - longest_[e] > options.tolerance * rest_[e];
    if (!corrected[e]) return;
    const Vec3 shift = (length - longest_[e]) / (length * (wa + wb)) * d;
    if (wa > 0.0) x.row(a) += wa * shift.transpose();
    if (wb > 0.0) x.row(b) -= wb * shift.transpose();
  };
  LimitReport report;
  while (report.sweeps < options.max_sweeps) {
    bool clean = true;
    for (Index i = 0; i < n_colours; ++i) {
      const std::vector<Index>& list = active[report.sweeps % 2 == 0 ? i : n_colours - 1 - i];
      report.evaluations += static_cast<std::int64_t>(list.size());
      parallel_for(team, static_cast<Index>(list.size()), [&](Index k) { correct(list[k]); });
      clean = clean &&
              std::none_of(list.begin(), list.end(), [&](Index e) { return corrected[e] != 0; });
    }
    ++report.sweeps;
    if (clean) break;
    if (!options.active_set) continue;
    for (Index e = 0; e < n; ++e) {
      if (!corrected[e] || spread[e]) continue;
      spread[e] = 1;
      for (int k = 0; k < 2; ++k)
        for (Index s = edge_start_[edges_(e, k)]; s < edge_start_[edges_(e, k) + 1]; ++s)
          in[edges_of_[s]] = 1;
    }
    for (Index c = 0; c < n_colours; ++c) {
      active[c].clear();
      for (Index e = colour_start_[c]; e < colour_start_[c + 1]; ++e)
        if (in[e]) active[c].push_back(e);
    }
  }
  return report;
}

}  // namespace loomstone
