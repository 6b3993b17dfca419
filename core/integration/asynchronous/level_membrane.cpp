#include "core/integration/asynchronous/level_membrane.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/same_bits.h"
#include "core/base/simd.h"

namespace loomstone {

namespace {

constexpr Index batches_per_range = 32;

// Returns the triangles in the order of their levels, finest first. If the last batch of a level is
// not full, the next triangles fill it, and their levels are raised to this level.
std::vector<Index> sort_by_level(std::vector<std::uint8_t>& levels) {
  std::vector<Index> order(levels.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return levels[a] > levels[b]; });
  for (std::size_t i = 0; i < order.size(); ++i)
    levels[order[i]] = levels[order[i / n_lanes * n_lanes]];
  return order;
}

Membrane make_membrane(const ClothModel& model, const std::vector<Index>& order) {
  Triangles triangles(static_cast<Index>(order.size()), 3);
  std::vector<Corners2> corners;
  std::vector<MembraneConstants> constants;
  for (const Index t : order) {
    triangles.row(static_cast<Index>(corners.size())) = model.triangles.row(t);
    corners.push_back(model.corners[t]);
    constants.push_back(model.constants_of(t));
  }
  return {model.n_vertices, triangles, corners, constants};
}

}  // namespace

LevelMembrane::LevelMembrane(const ClothModel& model, const ElementSteps& steps,
                             const std::vector<LimitModes>& limits,
                             std::vector<std::uint8_t>& levels)
    : LevelMembrane(model, steps, sort_by_level(levels), levels) {
  if (limits.empty()) return;
  std::vector<LimitModes> sorted;
  for (const Index t : order_) sorted.push_back(limits[t]);
  membrane_.add_limits(sorted);
  entered_.assign(membrane::entered_stride * static_cast<std::size_t>(membrane_.n_batches()), 0);
}

LevelMembrane::LevelMembrane(const ClothModel& model, const ElementSteps& steps,
                             std::vector<Index> order, const std::vector<std::uint8_t>& levels)
    : membrane_(make_membrane(model, order)),
      order_(std::move(order)),
      batches_(membrane_.n_batches()),
      slot_start_(model.n_vertices + 1, 0),
      slots_(3 * levels.size()),
      vertex_levels_(model.n_vertices, 0),
      forces_(static_cast<std::size_t>(membrane_.n_batches()) * membrane::force_stride) {
  std::iota(batches_.begin(), batches_.end(), 0);
  batch_end_.assign(levels[order_.front()] + 1, 0);
  for (std::size_t i = 0; i < order_.size(); ++i)
    for (int level = levels[order_[i]]; level >= 0; --level)
      batch_end_[level] = static_cast<Index>(i / n_lanes) + 1;
  for (Index t = 0; t < model.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index vertex = model.triangles(t, k);
      ++slot_start_[vertex + 1];
      vertex_levels_[vertex] = std::max(vertex_levels_[vertex], levels[t]);
    }
  std::partial_sum(slot_start_.begin(), slot_start_.end(), slot_start_.begin());
  std::vector<Index> fill(slot_start_.begin(), slot_start_.end() - 1);
  for (Index i = 0; i < static_cast<Index>(order_.size()); ++i)
    for (int k = 0; k < 3; ++k) {
      const Index t = order_[i];
      slots_[fill[model.triangles(t, k)]++] = {
          (i / n_lanes) * membrane::force_stride + 3 * n_lanes * k + i % n_lanes, levels[t],
          steps.share(t, k)};
    }
  if (!membrane_.viscous()) return;
  rates_ = Points::Zero(model.n_vertices, 3);
  last_.assign(batch_end_.size(), rates_);
  vertices_of_.resize(batch_end_.size());
  for (Index i = 0; i < model.n_vertices; ++i)
    for (Index s = slot_start_[i]; s < slot_start_[i + 1]; ++s)
      if (s == slot_start_[i] || slots_[s].level != slots_[s - 1].level)
        vertices_of_[slots_[s].level].push_back(i);
}

std::vector<Index> LevelMembrane::triangles_from(int first) const {
  if (first > finest()) return {};
  const std::size_t end =
      std::min(order_.size(), n_lanes * static_cast<std::size_t>(batch_end_[first]));
  return {order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(end)};
}

std::vector<LimitPhases> LevelMembrane::take_phases() {
  std::vector<LimitPhases> phases;
  if (entered_.empty()) return phases;
  phases.resize(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i)
    phases[order_[i]] = phases_of_lane(entered_.data() + membrane::entered_stride * (i / n_lanes),
                                       static_cast<int>(i % n_lanes));
  std::fill(entered_.begin(), entered_.end(), 0);
  return phases;
}

// Sets rates_ at the vertices of a level to their mean velocities since the last event of the
// level, which took place `step` [s] ago.
void LevelMembrane::find_rates(const Team& team, int level, const Points& x, double step) {
  const std::vector<Index>& list = vertices_of_[level];
  parallel_for(team, static_cast<Index>(list.size()), [&](Index i) {
    rates_.row(list[i]) = (x.row(list[i]) - last_[level].row(list[i])) / step;
  });
}

void LevelMembrane::measure(const Team& team, int first, const Points& x, const Points* v,
                            const std::vector<double>& step_of) {
  if (first > finest()) return;
  if (!membrane_.viscous()) {
    if (v && same_bits(x, known_x_)) return;
    if (first == 0) known_x_ = x;
  }
  membrane::Tables tables = membrane_.tables();
  if (!entered_.empty()) tables.entered = entered_.data();
  const auto compute = [&](Index begin, Index end, const double* velocity) {
    parallel_ranges(team, end - begin, batches_per_range, [&](Index from, Index to) {
      membrane::forces(tables, batches_.data() + begin + from, to - from, x.data(), velocity,
                       forces_.data());
    });
  };
  if (!membrane_.viscous()) return compute(0, batch_end_[first], nullptr);
  for (int level = first; level <= finest(); ++level) {
    if (!v) find_rates(team, level, x, step_of[level]);
    tables.rate_time = v ? 0.0 : step_of[level];
    compute(level < finest() ? batch_end_[level + 1] : 0, batch_end_[level],
            v ? v->data() : rates_.data());
    for (const Index i : vertices_of_[level]) last_[level].row(i) = x.row(i);
  }
}

}  // namespace loomstone
