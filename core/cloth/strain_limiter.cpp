#include "core/cloth/strain_limiter.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "core/cloth/edge_limiter.h"

namespace loomstone {

namespace {

constexpr Index batches_per_range = 16;

// Numbers of a sequence that a key starts, splitmix64 [Steele2014].
class Sequence {
 public:
  explicit Sequence(std::uint64_t key) : state_(key) {}
  Index below(Index n) {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return static_cast<Index>((z >> 32) * static_cast<std::uint64_t>(n) >> 32);
  }

 private:
  std::uint64_t state_;
};

std::uint64_t mixed(std::uint64_t a, std::uint64_t b) { return (a ^ (b + 0x9e3779b97f4a7c15u + (a << 6) + (a >> 2))) * 0xff51afd7ed558ccdu; }

}  // namespace

// The elements that sweeps look at: all, or, after the first sweep, those once corrected and their neighbours (by batches, which
// are looked at whole). The set only grows.
struct StrainLimiter::Active {
  std::vector<std::vector<Index>> batches;   // of each colour, ascending
  std::vector<std::uint8_t> in, spread;      // (batches) bits of lanes in `spread`
  Index n_elements = 0;

  explicit Active(const LimitElements& elements) {
    const auto& start = elements.colour_start();
    for (std::size_t c = 0; c + 1 < start.size(); ++c) {
      batches.emplace_back(start[c + 1] - start[c]);
      std::iota(batches.back().begin(), batches.back().end(), start[c]);
    }
    n_elements = elements.n_elements();
  }

  void grow(const LimitElements& elements, const std::vector<std::uint8_t>& corrected) {
    const bool first = in.empty();
    if (first) in.assign(corrected.size(), 0), spread.assign(corrected.size(), 0), n_elements = 0;
    std::vector<Index> entered;
    for (const std::vector<Index>& of_colour : batches)
      for (const Index b : of_colour) {
        const unsigned fresh = corrected[b] & ~spread[b];
        spread[b] = static_cast<std::uint8_t>(spread[b] | fresh);
        for (unsigned bits = fresh; bits != 0; bits &= bits - 1) {
          const Index slot = 8 * b + __builtin_ctz(bits);
          for (int k = 0; k < 3; ++k) {
            const Index v = elements.corners(slot)[8 * k];
            for (Index s = elements.slot_start()[v]; s < elements.slot_start()[v + 1]; ++s) {
              const Index other = elements.slots()[s] / 8;
              if (in[other]) continue;
              in[other] = 1;
              entered.push_back(other);
            }
          }
        }
      }
    if (first)
      for (std::vector<Index>& of_colour : batches) of_colour.clear();
    if (entered.empty()) return;
    std::sort(entered.begin(), entered.end());
    const auto& start = elements.colour_start();
    auto next = entered.begin();
    for (std::size_t c = 0; c < batches.size() && next != entered.end(); ++c) {
      const auto end = std::lower_bound(next, entered.end(), start[c + 1]);
      const auto middle = batches[c].insert(batches[c].end(), next, end);
      std::inplace_merge(batches[c].begin(), middle, batches[c].end());
      next = end;
    }
    for (const Index b : entered)
      for (Index l = 0; l < 8; ++l) n_elements += elements.element(8 * b + l) >= 0;
  }
};

StrainLimiter::StrainLimiter(const LimitedCloth& cloth, const LimitOptions& options)
    : options_(options), elements_(cloth, options.method == "gauss-seidel-random") {
  for (const StrainLimit& limit : cloth.limits)  // what is left to contacts must exceed what is left to sweeps
    for (const double bound : {limit.weft, limit.warp, limit.shear, limit.weft_min, limit.warp_min, limit.least_shear()})
      options_.tolerance = std::min(options_.tolerance, 0.5 * limit_margin(bound));
  LimitedCloth by_edges = cloth;
  Index n_edges = 0;
  for (Index& limit : by_edges.limit_of) {
    if (limit >= 0 && options.method != "edges" && !cloth.limits[limit].edge) limit = -1;
    n_edges += limit >= 0;
  }
  if (n_edges > 0) edges_ = std::make_unique<EdgeLimiter>(by_edges);
  by_elements_ = n_edges < elements_.n_elements();
  corrected_.assign(elements_.n_batches(), 0);
  strains_.resize(24 * static_cast<std::size_t>(elements_.n_batches()));
  if (options.method == "jacobi") {
    deltas_.resize(72 * static_cast<std::size_t>(elements_.n_batches()));
    n_corrected_.resize(cloth.n_vertices);
  }
}

StrainLimiter::~StrainLimiter() = default;

LimitReport StrainLimiter::enforce(const Team& team, std::uint64_t key, const std::vector<Index>& held, Points& x) {
  if (empty()) return {};
  elements_.hold(held);
  const limit::Motion motion{x.data(), nullptr, options_.tolerance};
  LimitReport report;
  if (by_elements_) report = enforce(team, key, elements_.sweep_tables(options_.method == "edges"), motion);
  if (edges_) {
    const LimitReport done = edges_->enforce(team, options_, held, x);
    report.sweeps = std::max(report.sweeps, done.sweeps);
    report.evaluations += done.evaluations;
  }
  measure(team, elements_.tables(), motion, 1.0, report);
  return report;
}

LimitReport StrainLimiter::enforce_rate(const Team& team, std::uint64_t key, const Points& x, double h, Points& v,
                                        bool measured) {
  if (empty() || options_.strain_rate == 0.0) return {};
  elements_.hold({});
  const limit::Tables tables = elements_.rate_tables(options_.strain_rate / h);
  const limit::Motion motion{const_cast<double*>(x.data()), v.data(), options_.tolerance / h};
  LimitReport report = enforce(team, key, tables, motion);
  if (measured) measure(team, tables, motion, h, report);
  return report;
}

LimitReport StrainLimiter::measure(const Team& team, const Points& x) {
  if (empty()) return {};
  LimitReport report;
  measure(team, elements_.tables(), {const_cast<double*>(x.data()), nullptr, options_.tolerance}, 1.0, report);
  return report;
}

LimitReport StrainLimiter::enforce(const Team& team, std::uint64_t key, const limit::Tables& tables, const limit::Motion& motion) {
  LimitReport report;
  Active active(elements_);
  std::vector<Index> order;
  while (report.sweeps < options_.max_sweeps) {
    report.evaluations += active.n_elements;
    std::int64_t n = 0;
    if (options_.method == "jacobi")
      n = sweep_jacobi(team, tables, motion, active);
    else if (options_.method == "gauss-seidel-random")
      n = sweep_randomly(tables, motion, mixed(mixed(static_cast<std::uint64_t>(options_.seed), key), report.sweeps), active, order);
    else
      n = sweep(team, tables, motion, report.sweeps, active);
    ++report.sweeps;
    if (n == 0) break;  // every element that can be is within its limits
    if (options_.active_set) active.grow(elements_, corrected_), order.clear();
  }
  return report;
}

void StrainLimiter::run_batches(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
                                const std::vector<Index>& batches) {
  parallel_ranges(team, static_cast<Index>(batches.size()), batches_per_range, [&](Index first, Index last) {
    limit::Seen seen;
    if (deltas_.empty())
      limit::sweep(tables, motion, batches.data() + first, last - first, corrected_.data(), seen);
    else
      limit::corrections(tables, motion, batches.data() + first, last - first, corrected_.data(), deltas_.data(), seen);
  });
}

std::int64_t StrainLimiter::sweep(const Team& team, const limit::Tables& tables, const limit::Motion& motion, int number,
                                  const Active& active) {
  const std::size_t n = active.batches.size();
  std::int64_t corrected = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::vector<Index>& batches = active.batches[number % 2 == 0 ? i : n - 1 - i];  // there and back: less bias
    run_batches(team, tables, motion, batches);
    for (const Index b : batches) corrected += __builtin_popcount(corrected_[b]);
  }
  return corrected;
}

// Corrections of an element scaled by one factor, one over the largest number of elements corrected at one of its vertices: the
// plain sum (3.17) diverges, and scaling per vertex would lose momentum.
std::int64_t StrainLimiter::sweep_jacobi(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
                                         const Active& active) {
  std::vector<Index> all;
  for (const auto& batches : active.batches) all.insert(all.end(), batches.begin(), batches.end());
  run_batches(team, tables, motion, all);
  std::int64_t corrected = 0;
  for (const Index b : all) corrected += __builtin_popcount(corrected_[b]);
  if (corrected == 0) return 0;
  const auto& start = elements_.slot_start();
  const auto& slots = elements_.slots();
  const auto is_corrected = [&](Index slot) { return corrected_[slot / 8] >> (slot % 8) & 1; };
  const Index n = static_cast<Index>(n_corrected_.size());
  parallel_for(team, n, [&](Index v) {
    Index count = 0;
    for (Index s = start[v]; s < start[v + 1]; ++s) count += is_corrected(slots[s]);
    n_corrected_[v] = count;
  });
  double* const values = motion.v ? motion.v : motion.x;
  parallel_for(team, n, [&](Index v) {
    if (n_corrected_[v] == 0) return;
    double sum[3] = {0.0, 0.0, 0.0};
    bool moves = false;
    for (Index s = start[v]; s < start[v + 1]; ++s) {
      const Index slot = slots[s];
      if (!is_corrected(slot)) continue;
      const Index* corners = elements_.corners(slot);
      const int k = corners[0] == v ? 0 : corners[8] == v ? 1 : 2;
      if (!(tables.moves[slot] >> k & 1)) continue;
      moves = true;
      const double factor = 1.0 / std::max({n_corrected_[corners[0]], n_corrected_[corners[8]], n_corrected_[corners[16]]});
      const double* delta = deltas_.data() + 72 * static_cast<std::size_t>(slot / 8) + 24 * k + slot % 8;
      sum[0] += factor * delta[0], sum[1] += factor * delta[8], sum[2] += factor * delta[16];
    }
    double* p = values + 3 * static_cast<std::size_t>(v);
    if (moves) p[0] += sum[0], p[1] += sum[1], p[2] += sum[2];
  });
  return corrected;
}

std::int64_t StrainLimiter::sweep_randomly(const limit::Tables& tables, const limit::Motion& motion, std::uint64_t key,
                                           const Active& active, std::vector<Index>& order) {
  if (order.empty())
    for (const auto& batches : active.batches)
      for (const Index b : batches)
        for (Index slot = 8 * b; slot < 8 * b + 8; ++slot)
          if (elements_.element(slot) >= 0) order.push_back(slot);
  Sequence random(key);
  for (Index i = static_cast<Index>(order.size()) - 1; i > 0; --i) std::swap(order[i], order[random.below(i + 1)]);
  std::fill(corrected_.begin(), corrected_.end(), 0);
  std::int64_t corrected = 0;
  limit::Seen seen;
  for (const Index slot : order)
    if (limit::correct_one(tables, motion, slot, seen)) {
      corrected_[slot / 8] = static_cast<std::uint8_t>(corrected_[slot / 8] | 1 << slot % 8);
      ++corrected;
    }
  return corrected;
}

// What is left; `unit` makes strain of it.
void StrainLimiter::measure(const Team& team, const limit::Tables& tables, const limit::Motion& motion, double unit,
                            LimitReport& report) {
  parallel_ranges(team, elements_.n_batches(), batches_per_range, [&](Index first, Index last) {
    limit::strains(tables, motion, first, last, strains_.data());
  });
  double most = 0.0;
  for (Index b = 0; b < elements_.n_batches(); ++b) {
    const limit::Bounds& bounds = tables.bounds[tables.bounds_of[b]];
    const double* strain = strains_.data() + 24 * static_cast<std::size_t>(b);
    double furthest = 0.0;  // of all lanes: nearly all batches are within their limits
    for (int k = 0; k < 3; ++k)
      for (int lane = 0; lane < 8; ++lane)
        furthest = std::max(furthest, std::max(strain[8 * k + lane] - bounds.high[k], bounds.low[k] - strain[8 * k + lane]));
    if (furthest <= 0.0) continue;
    for (Index lane = 0; lane < 8; ++lane) {
      const Index element = elements_.element(8 * b + lane);
      if (element < 0) continue;
      double largest = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double e = strain[8 * k + lane];
        const double beyond = std::max({0.0, e - bounds.high[k], bounds.low[k] - e});
        report.excess[k] = std::max(report.excess[k], unit * beyond);
        largest = std::max(largest, beyond);
        const double margin = limit_margin(e > bounds.high[k] ? bounds.high[k] : bounds.low[k]);
        if (!motion.v && beyond > margin) report.broken.push_back({element, k, beyond});
      }
      report.beyond += largest > motion.tolerance;
      if (largest > most || (largest == most && most > 0.0 && element < report.worst)) most = largest, report.worst = element;
    }
  }
  std::sort(report.broken.begin(), report.broken.end(), [](const BrokenLimit& a, const BrokenLimit& b) {
    return std::tuple(-a.excess, a.element, a.mode) < std::tuple(-b.excess, b.element, b.mode);
  });
}

Vec3 corotational_strain(const Vec3& green) {
  const double c11 = 1.0 + 2.0 * green[0], c22 = 1.0 + 2.0 * green[1], c12 = 2.0 * green[2];
  const double d = std::sqrt(std::max(0.0, c11 * c22 - c12 * c12)), s = std::sqrt(c11 + c22 + 2.0 * d) + 1e-300;
  return {(c11 + d) / s - 1.0, (c22 + d) / s - 1.0, c12 / s};
}

void corotational_strain(const Team& team, const Triangles& triangles, const std::vector<Corners2>& corners, const Points& x,
                         Points& strain) {
  strain.resize(triangles.rows(), 3);
  parallel_for(team, static_cast<Index>(triangles.rows()), [&](Index t) {
    const Corners2& c = corners[t];
    const Vec2 e0 = (c.row(0) - c.row(2)).transpose(), e1 = (c.row(1) - c.row(2)).transpose();
    const double determinant = e0.x() * e1.y() - e0.y() * e1.x();
    limit::Element<double> element{};
    element.g0x = e1.y() / determinant, element.g0y = -e1.x() / determinant;
    element.g1x = -e0.y() / determinant, element.g1y = e0.x() / determinant;
    const auto corner = [&](int k) {
      return limit::Space<double>{x(triangles(t, k), 0), x(triangles(t, k), 1), x(triangles(t, k), 2)};
    };
    const limit::Polar<double> p = limit::stretch(element, corner(0), corner(1), corner(2));
    strain.row(t) << p.u.a11 - 1.0, p.u.a22 - 1.0, p.u.a12;
  });
}

}  // namespace loomstone
