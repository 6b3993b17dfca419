#include "core/cloth/limits/limit_elements.h"

#include <algorithm>

#include "core/base/sort_unique.h"

namespace loomstone {

LimitElements::LimitElements(const LimitedCloth& cloth, bool single_rows)
    : cloth_(cloth), held_(cloth.prescribed) {
  std::vector<Index> elements;
  for (std::size_t t = 0; t < cloth.limit_of.size(); ++t)
    if (cloth.limit_of[t] >= 0) elements.push_back(static_cast<Index>(t));
  n_elements_ = static_cast<Index>(elements.size());
  Triangles rows(n_elements_, 3);
  for (Index i = 0; i < n_elements_; ++i) rows.row(i) = cloth.triangles.row(elements[i]);
  Index n_colours = 0;
  const std::vector<Index> colour = colours(cloth.n_vertices, rows, n_colours);

  const Index n_limits = static_cast<Index>(cloth.limits.size());
  colour_start_.assign(1, 0);
  std::vector<std::vector<Index>> groups(static_cast<std::size_t>(n_colours) * n_limits);
  for (Index i = 0; i < n_elements_; ++i)
    groups[colour[i] * n_limits + cloth.limit_of[elements[i]]].push_back(elements[i]);
  for (Index c = 0; c < n_colours; ++c) {
    for (Index limit = 0; limit < n_limits; ++limit) {
      const std::vector<Index>& group = groups[c * n_limits + limit];
      for (std::size_t first = 0; first < group.size(); first += n_lanes) {
        bounds_of_.push_back(limit), colour_of_.push_back(c);
        n_in_.push_back(static_cast<Index>(std::min<std::size_t>(n_lanes, group.size() - first)));
        for (std::size_t i = first; i < first + n_lanes; ++i)
          element_of_.push_back(i < group.size() ? group[i] : -1);
      }
    }
    colour_start_.push_back(n_batches());
  }
  for (const StrainLimit& l : cloth.limits)
    bounds_.push_back({{l.weft_min, l.warp_min, l.least_shear()}, {l.weft, l.warp, l.shear}});

  const std::size_t n_slots = element_of_.size();
  corners_.resize(3 * n_slots);
  gradients_.resize(limit::element_gradients * n_slots);
  numbers_.resize((limit::element_numbers - limit::element_gradients) * n_slots);
  if (single_rows) rows_.resize(limit::element_numbers * n_slots);
  moves_.assign(n_slots, 0);
  slot_start_.assign(cloth.n_vertices + 1, 0);
  for (std::size_t slot = 0; slot < n_slots; ++slot) {
    set_element(static_cast<Index>(slot));
    if (element_of_[slot] < 0) continue;
    for (int k = 0; k < 3; ++k) ++slot_start_[cloth.triangles(element_of_[slot], k) + 1];
  }
  for (Index v = 0; v < cloth.n_vertices; ++v) slot_start_[v + 1] += slot_start_[v];
  slots_.resize(slot_start_[cloth.n_vertices]);
  std::vector<Index> fill(slot_start_.begin(), slot_start_.end() - 1);
  for (std::size_t slot = 0; slot < n_slots; ++slot)
    if (element_of_[slot] >= 0)
      for (int k = 0; k < 3; ++k)
        slots_[fill[cloth.triangles(element_of_[slot], k)]++] = static_cast<Index>(slot);
}

// Fills the tables of one slot. element_limit.h explains how held corners are treated. Empty lanes
// repeat the last element of the batch, but none of their corners may move.
void LimitElements::set_element(Index slot) {
  const bool empty = element_of_[slot] < 0;
  Index from = slot;
  while (element_of_[from] < 0) --from;
  const Index t = element_of_[from];
  const Corners2& c = cloth_.corners[t];
  const Vec2 e1 = (c.row(1) - c.row(0)).transpose(), e2 = (c.row(2) - c.row(0)).transpose();
  const double twice_area = e1.x() * e2.y() - e1.y() * e2.x();
  const Vec2 g1(e2.y() / twice_area, -e2.x() / twice_area),
      g2(-e1.y() / twice_area, e1.x() / twice_area);
  const Vec2 g[3] = {-(g1 + g2), g1, g2};

  bool held[3];
  int n_held = 0;
  for (int k = 0; k < 3; ++k) n_held += held[k] = held_[cloth_.triangles(t, k)] != 0;
  std::uint8_t moves = 0;
  Vec2 x[3] = {Vec2::Zero(), Vec2::Zero(), Vec2::Zero()};
  Mat2 moments = Mat2::Zero();
  if (n_held <= 1) {
    Vec2 centre = Vec2::Zero();
    double total = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double m = n_held == 0 ? cloth_.mass[cloth_.triangles(t, k)] : held[k] ? 1.0 : 0.0;
      centre += m * c.row(k).transpose();
      total += m;
    }
    centre /= total;
    for (int k = 0; k < 3; ++k) {
      if (held[k]) continue;
      x[k] = c.row(k).transpose() - centre;
      moments += cloth_.mass[cloth_.triangles(t, k)] / total * x[k] * x[k].transpose();
      moves |= 1 << k;
    }
  } else if (n_held == 2) {
    for (int k = 0; k < 3; ++k) {
      if (held[k]) continue;
      x[k] = g[k] / g[k].squaredNorm();  // height vector over the held edge
      moments = x[k] * x[k].transpose();
      moves = static_cast<std::uint8_t>(1 << k | limit::two_held);
    }
  }
  const double values[limit::element_numbers] = {
      g[0].x(), g[0].y(), g[1].x(), g[1].y(),      x[0].x(),      x[0].y(),     x[1].x(),
      x[1].y(), x[2].x(), x[2].y(), moments(0, 0), moments(1, 1), moments(0, 1)};
  const std::size_t batch = slot / n_lanes, lane = slot % n_lanes;
  constexpr int n_gradients = limit::element_gradients,
                n_others = limit::element_numbers - n_gradients;
  for (int k = 0; k < limit::element_numbers; ++k) {
    if (k < n_gradients)
      gradients_[n_lanes * (n_gradients * batch + k) + lane] = values[k];
    else
      numbers_[n_lanes * (n_others * batch + k - n_gradients) + lane] = values[k];
    if (!rows_.empty())
      rows_[limit::element_numbers * static_cast<std::size_t>(slot) + k] = values[k];
  }
  for (int k = 0; k < 3; ++k) corners_[n_lanes * (3 * batch + k) + lane] = cloth_.triangles(t, k);
  moves_[slot] = empty ? 0 : moves;
}

void LimitElements::hold(const std::vector<Index>& vertices) {
  std::vector<Index> changed;
  const auto set = [&](Index v, std::uint8_t value) {
    if (held_[v] == value) return;
    held_[v] = value;
    changed.push_back(v);
  };
  for (const Index v : also_held_) set(v, cloth_.prescribed[v]);
  for (const Index v : vertices) set(v, 1);
  also_held_ = vertices;
  std::vector<Index> touched;
  for (const Index v : changed)
    touched.insert(touched.end(), slots_.begin() + slot_start_[v],
                   slots_.begin() + slot_start_[v + 1]);
  sort_unique(touched);
  for (const Index slot : touched) set_element(slot);
}

limit::Tables LimitElements::tables() const {
  return {corners_.data(),
          gradients_.data(),
          numbers_.data(),
          moves_.data(),
          bounds_of_.data(),
          bounds_.data(),
          rows_.empty() ? nullptr : rows_.data()};
}

limit::Tables LimitElements::sweep_tables(bool edges) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  sweep_bounds_ = bounds_;
  for (std::size_t i = 0; i < sweep_bounds_.size(); ++i)
    if (edges || cloth_.limits[i].edge) sweep_bounds_[i] = {{-inf, -inf, -inf}, {inf, inf, inf}};
  limit::Tables t = tables();
  t.bounds = sweep_bounds_.data();
  return t;
}

limit::Tables LimitElements::rate_tables(double rate) {
  rate_bounds_.assign(bounds_.size(), {{-rate, -rate, -rate}, {rate, rate, rate}});
  limit::Tables t = tables();
  t.bounds = rate_bounds_.data();
  return t;
}

}  // namespace loomstone
