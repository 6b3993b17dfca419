#include "core/cloth/limits/strain_limiter.h"

#include <algorithm>
#include <bit>

#include "core/cloth/limits/active_set.h"
#include "core/cloth/limits/edge_limiter.h"

namespace loomstone {

namespace {

constexpr Index batches_per_sweep = 16;
constexpr Index listed = -1;  // entry of n_corrected_ for a vertex that corners_of() has listed

// Random number generator splitmix64 [Steele2014].
class Sequence {
 public:
  explicit Sequence(std::uint64_t seed) : state_(seed) {}
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

std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  return (a ^ (b + 0x9e3779b97f4a7c15u + (a << 6) + (a >> 2))) * 0xff51afd7ed558ccdu;
}

}  // namespace

StrainLimiter::StrainLimiter(const LimitedCloth& cloth, const LimitOptions& options,
                             const Communicator* ranks)
    : options_(options),
      elements_(cloth, options.method == LimitMethod::GaussSeidelRandom),
      check_(elements_, ranks) {
  // The tolerance of the sweeps is at most half the smallest limit_margin() of any bound other than
  // StrainLimit::edge.
  for (const StrainLimit& limit : cloth.limits)
    for (const double bound :
         {limit.weft, limit.warp, limit.shear, limit.weft_min, limit.warp_min, limit.least_shear()})
      options_.tolerance = std::min(options_.tolerance, 0.5 * limit_margin(bound));
  LimitedCloth by_edges = cloth;
  Index n_edges = 0;
  for (Index& limit : by_edges.limit_of) {
    if (limit >= 0 && options.method != LimitMethod::Edges && !cloth.limits[limit].edge) limit = -1;
    n_edges += limit >= 0;
  }
  if (n_edges > 0) edges_ = std::make_unique<EdgeLimiter>(by_edges);
  by_elements_ = n_edges < elements_.n_elements();
  corrected_.assign(elements_.n_batches(), 0);
  if (options.method == LimitMethod::Jacobi) {
    deltas_.resize(72 * static_cast<std::size_t>(elements_.n_batches()));
    n_corrected_.resize(cloth.n_vertices);
  }
}

StrainLimiter::~StrainLimiter() = default;

LimitReport StrainLimiter::enforce(const Team& team, std::uint64_t key,
                                   const std::vector<Index>& held, Points& x) {
  if (empty()) return {};
  elements_.hold(held);
  const limit::Motion motion{x.data(), nullptr, options_.tolerance};
  LimitReport report;
  bool checked = false;
  if (by_elements_)
    checked = sweep_until_met(
        team, key, elements_.sweep_tables(options_.method == LimitMethod::Edges), motion, report);
  if (edges_) {
    const LimitReport done = edges_->enforce(team, options_, held, x);
    report.sweeps = std::max(report.sweeps, done.sweeps);
    report.evaluations += done.evaluations;
  }
  const limit::Tables tables = elements_.tables();
  if (!checked || edges_) check_.check_all(team, tables, motion);
  check_.add_to(report, tables, motion, 1.0);
  return report;
}

LimitReport StrainLimiter::enforce_rate(const Team& team, std::uint64_t key, const Points& x,
                                        double h, Points& v, bool measured) {
  if (empty() || options_.strain_rate == 0.0) return {};
  elements_.hold({});
  const limit::Tables tables = elements_.rate_tables(options_.strain_rate / h);
  const limit::Motion motion{const_cast<double*>(x.data()), v.data(), options_.tolerance / h};
  LimitReport report;
  const bool checked = sweep_until_met(team, key, tables, motion, report);
  if (!measured) return report;
  if (!checked) check_.check_all(team, tables, motion);
  check_.add_to(report, tables, motion, h);
  return report;
}

LimitReport StrainLimiter::measure(const Team& team, const Points& x) {
  if (empty()) return {};
  LimitReport report;
  const limit::Tables tables = elements_.tables();
  const limit::Motion motion{const_cast<double*>(x.data()), nullptr, options_.tolerance};
  check_.check_all(team, tables, motion);
  check_.add_to(report, tables, motion, 1.0);
  return report;
}

bool StrainLimiter::sweep_until_met(const Team& team, std::uint64_t key,
                                    const limit::Tables& tables, const limit::Motion& motion,
                                    LimitReport& report) {
  const bool randomly = options_.method == LimitMethod::GaussSeidelRandom;
  ActiveSet active(
      elements_, tables,
      options_.active_set ? ActiveSet::Contents::Violations : ActiveSet::Contents::AllElements,
      randomly ? ActiveSet::Order::SingleElements : ActiveSet::Order::Batches);
  if (options_.active_set) {
    check_.check_all(team, tables, motion);
    report.evaluations += elements_.n_elements();
    bool any = false;
    for (Index b = 0; b < elements_.n_batches(); ++b)
      if (check_.excess(b) > motion.tolerance) active.add(b), any = true;
    if (!any) {
      ++report.sweeps;
      return true;
    }
  }
  std::fill(corrected_.begin(), corrected_.end(), 0);
  while (report.sweeps < options_.max_sweeps) {
    std::int64_t n = 0;
    if (options_.method == LimitMethod::Jacobi)
      n = sweep_jacobi(team, tables, motion, active);
    else if (randomly)
      n = sweep_randomly(
          tables, motion,
          mixed(mixed(static_cast<std::uint64_t>(options_.seed), key), report.sweeps), active);
    else
      n = sweep(team, tables, motion, report.sweeps, active);
    ++report.sweeps;
    if (n == 0) break;  // no element had to be corrected
  }
  report.evaluations += active.evaluations();
  if (options_.active_set) check_.check(team, tables, motion, active.moved());
  return options_.active_set;
}

void StrainLimiter::run_batches(const Team& team, const limit::Tables& tables,
                                const limit::Motion& motion, const std::vector<Index>& batches) {
  parallel_ranges(
      team, static_cast<Index>(batches.size()), batches_per_sweep, [&](Index first, Index last) {
        if (deltas_.empty())
          limit::sweep(tables, motion, batches.data() + first, last - first, corrected_.data());
        else
          limit::corrections(tables, motion, batches.data() + first, last - first,
                             corrected_.data(), deltas_.data());
      });
}

// Returns the number of corrected elements in `batches`. Calls active.spread() for these elements
// unless active.all_elements() is true.
std::int64_t StrainLimiter::spread(const std::vector<Index>& batches, ActiveSet& active) const {
  std::int64_t corrected = 0;
  if (active.all_elements()) {
    for (const Index b : batches) corrected += std::popcount(corrected_[b]);
    return corrected;
  }
  for (const Index b : batches)
    for (unsigned bits = corrected_[b]; bits != 0; bits &= bits - 1, ++corrected)
      active.spread(8 * b + __builtin_ctz(bits));
  return corrected;
}

std::int64_t StrainLimiter::sweep(const Team& team, const limit::Tables& tables,
                                  const limit::Motion& motion, int number, ActiveSet& active) {
  const std::size_t n = active.n_colours();
  std::int64_t corrected = 0;
  std::vector<Index> batches;
  for (std::size_t i = 0; i < n; ++i) {
    batches.clear();
    active.take(number % 2 == 0 ? i : n - 1 - i, batches);  // alternating orders reduce bias
    run_batches(team, tables, motion, batches);
    corrected += spread(batches, active);
  }
  return corrected;
}

// Returns the vertices of the corrected elements in the batches, without duplicates. Marks these
// vertices as `listed` in n_corrected_.
std::vector<Index> StrainLimiter::corners_of(const std::vector<Index>& batches) {
  std::vector<Index> vertices;
  for (const Index b : batches)
    for (unsigned bits = corrected_[b]; bits != 0; bits &= bits - 1)
      for (int k = 0; k < 3; ++k)
        if (const Index v = elements_.corners(8 * b + __builtin_ctz(bits))[8 * k];
            n_corrected_[v] != listed) {
          n_corrected_[v] = listed;
          vertices.push_back(v);
        }
  return vertices;
}

// Divides all triangles into one part for each thread, and returns the batches sorted by the part
// of their first element. Within a part, batches keep their order. If sweep_jacobi() visits all
// vertices, a thread thus mostly sums corrections that it has computed itself.
std::vector<Index> StrainLimiter::by_thread(const Team& team,
                                            const std::vector<Index>& batches) const {
  if (team.threads <= 1) return batches;
  std::vector<std::vector<Index>> parts(team.threads);
  for (const Index b : batches)
    parts[std::int64_t{elements_.element(8 * b)} * team.threads / elements_.n_triangles()]
        .push_back(b);
  std::vector<Index> result;
  for (const std::vector<Index>& part : parts)
    result.insert(result.end(), part.begin(), part.end());
  return result;
}

// Performs a Jacobi sweep. The correction of an element is divided by the largest number of
// corrected elements at any of its vertices. The plain sum, (3.17) of [Thomaszewski2010], diverges,
// and scaling per vertex would not conserve momentum.
std::int64_t StrainLimiter::sweep_jacobi(const Team& team, const limit::Tables& tables,
                                         const limit::Motion& motion, ActiveSet& active) {
  std::vector<Index> batches;
  for (std::size_t c = 0; c < active.n_colours(); ++c) active.take(c, batches);
  run_batches(team, tables, motion, by_thread(team, batches));
  const std::int64_t corrected = spread(batches, active);
  if (corrected == 0) return 0;
  const auto& start = elements_.slot_start();
  const auto& slots = elements_.slots();
  const auto is_corrected = [&](Index slot) { return corrected_[slot / 8] >> (slot % 8) & 1; };
  const bool few = corrected < elements_.n_elements() / 8;  // otherwise all vertices are visited
  std::vector<Index> vertices;
  if (few) vertices = corners_of(batches);
  const Index n =
      few ? static_cast<Index>(vertices.size()) : static_cast<Index>(n_corrected_.size());
  parallel_for(team, n, [&](Index i) {
    const Index v = few ? vertices[i] : i;
    Index count = 0;
    for (Index s = start[v]; s < start[v + 1]; ++s) count += is_corrected(slots[s]);
    n_corrected_[v] = count;
  });
  double* const values = motion.v ? motion.v : motion.x;
  parallel_for(team, n, [&](Index i) {
    const Index v = few ? vertices[i] : i;
    double sum[3] = {0.0, 0.0, 0.0};
    bool moves = false;
    for (Index s = start[v]; s < start[v + 1]; ++s) {
      const Index slot = slots[s];
      if (!is_corrected(slot)) continue;
      const Index* corners = elements_.corners(slot);
      const int k = corners[0] == v ? 0 : corners[8] == v ? 1 : 2;
      if (!(tables.moves[slot] >> k & 1)) continue;
      moves = true;
      const double factor = 1.0 / std::max({n_corrected_[corners[0]], n_corrected_[corners[8]],
                                            n_corrected_[corners[16]]});
      const double* delta =
          deltas_.data() + 72 * static_cast<std::size_t>(slot / 8) + 24 * k + slot % 8;
      sum[0] += factor * delta[0], sum[1] += factor * delta[8], sum[2] += factor * delta[16];
    }
    double* p = values + 3 * static_cast<std::size_t>(v);
    if (moves) p[0] += sum[0], p[1] += sum[1], p[2] += sum[2];
  });
  return corrected;
}

std::int64_t StrainLimiter::sweep_randomly(const limit::Tables& tables, const limit::Motion& motion,
                                           std::uint64_t key, ActiveSet& active) {
  if (order_.empty())
    for (Index slot = 0; slot < 8 * elements_.n_batches(); ++slot)
      if (elements_.element(slot) >= 0) order_.push_back(slot);
  std::vector<Index> order = order_;
  Sequence random(key);
  for (Index i = static_cast<Index>(order.size()) - 1; i > 0; --i)
    std::swap(order[i], order[random.below(i + 1)]);
  std::int64_t corrected = 0;
  for (const Index slot : order)
    if (active.take_one(slot) && limit::correct_one(tables, motion, slot)) {
      active.spread(slot);
      ++corrected;
    }
  return corrected;
}

}  // namespace loomstone
