#include "core/cloth/limits/strain_limiter.h"

#include <algorithm>
#include <bit>

#include "core/cloth/limits/edge_limiter.h"

namespace loomstone {

namespace {

constexpr Index batches_per_range = 16;
constexpr Index listed = -1;  // of n_corrected_, until it is counted

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

std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  return (a ^ (b + 0x9e3779b97f4a7c15u + (a << 6) + (a >> 2))) * 0xff51afd7ed558ccdu;
}

}  // namespace

// What sweeps still have to evaluate: everything, or, with an active set, the batches that a look
// has found beyond their bounds, then those of which a vertex has moved since they were evaluated
// last. Any other would be found as it was, so that the bits are those of sweeps over everything.
class StrainLimiter::Pending {
 public:
  // singly: in the random order, element by element.
  Pending(const LimitElements& elements, const limit::Tables& tables, bool everything, bool singly)
      : elements_(elements),
        tables_(tables),
        everything_(everything),
        singly_(singly),
        waits_(elements.n_batches(), everything ? every_lane : 0),
        moved_(elements.n_batches(), 0),
        of_colour_(elements.colour_start().size() - 1) {
    if (everything && !singly)
      for (Index b = 0; b < elements.n_batches(); ++b) of_colour_[elements.colour(b)].push_back(b);
  }

  std::size_t n_colours() const { return of_colour_.size(); }
  std::int64_t evaluations() const { return evaluations_; }
  const std::vector<Index>& moved() const {
    return moved_list_;
  }  // batches of which a vertex has ever moved

  void add(Index batch) {
    if (!singly_ && !waits_[batch]) of_colour_[elements_.colour(batch)].push_back(batch);
    waits_[batch] = every_lane;
  }

  // Appends the batches of a colour that are to be evaluated now.
  void take(std::size_t colour, std::vector<Index>& list) {
    std::vector<Index>& batches = of_colour_[colour];
    list.insert(list.end(), batches.begin(), batches.end());
    for (const Index b : batches) evaluations_ += elements_.n_elements(b);
    if (everything_) return;
    for (const Index b : batches) waits_[b] = 0;
    batches.clear();
  }

  // Whether a single element is to be evaluated now.
  bool take_one(Index slot) {
    const unsigned waiting = waits_[slot / 8], lane = 1u << slot % 8;
    if (!(waiting & lane)) return false;
    if (!everything_) waits_[slot / 8] = static_cast<std::uint8_t>(waiting & ~lane);
    ++evaluations_;
    return true;
  }

  bool everything() const { return everything_; }  // nothing needs to be told what was corrected

  // An element was corrected: all that shares a vertex that moved is to be evaluated again.
  void spread(Index corrected) {
    if (everything_) return;
    for (int k = 0; k < 3; ++k) {
      if (!(tables_.moves[corrected] >> k & 1)) continue;
      const Index v = elements_.corners(corrected)[8 * k];
      for (Index s = elements_.slot_start()[v]; s < elements_.slot_start()[v + 1]; ++s) {
        const Index slot = elements_.slots()[s], b = slot / 8;
        if (!moved_[b]) moved_[b] = 1, moved_list_.push_back(b);
        if (singly_)
          waits_[b] = static_cast<std::uint8_t>(waits_[b] | 1u << slot % 8);
        else
          add(b);
      }
    }
  }

 private:
  static constexpr std::uint8_t every_lane = 255;
  const LimitElements& elements_;
  const limit::Tables& tables_;
  const bool everything_, singly_;
  std::vector<std::uint8_t> waits_, moved_;  // (batches) bits of lanes, flags
  std::vector<std::vector<Index>> of_colour_;
  std::vector<Index> moved_list_;
  std::int64_t evaluations_ = 0;
};

StrainLimiter::StrainLimiter(const LimitedCloth& cloth, const LimitOptions& options,
                             const Communicator* ranks)
    : options_(options),
      elements_(cloth, options.method == "gauss-seidel-random"),
      look_(elements_, ranks) {
  for (const StrainLimit& limit :
       cloth.limits)  // what is left to contacts must exceed what is left to sweeps
    for (const double bound :
         {limit.weft, limit.warp, limit.shear, limit.weft_min, limit.warp_min, limit.least_shear()})
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
  if (options.method == "jacobi") {
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
  bool seen = false;
  if (by_elements_)
    seen = enforce(team, key, elements_.sweep_tables(options_.method == "edges"), motion, report);
  if (edges_) {
    const LimitReport done = edges_->enforce(team, options_, held, x);
    report.sweeps = std::max(report.sweeps, done.sweeps);
    report.evaluations += done.evaluations;
  }
  const limit::Tables tables = elements_.tables();
  if (!seen || edges_) look_.at_all(team, tables, motion);
  look_.tell(tables, motion, 1.0, report);
  return report;
}

LimitReport StrainLimiter::enforce_rate(const Team& team, std::uint64_t key, const Points& x,
                                        double h, Points& v, bool measured) {
  if (empty() || options_.strain_rate == 0.0) return {};
  elements_.hold({});
  const limit::Tables tables = elements_.rate_tables(options_.strain_rate / h);
  const limit::Motion motion{const_cast<double*>(x.data()), v.data(), options_.tolerance / h};
  LimitReport report;
  const bool seen = enforce(team, key, tables, motion, report);
  if (!measured) return report;
  if (!seen) look_.at_all(team, tables, motion);
  look_.tell(tables, motion, h, report);
  return report;
}

LimitReport StrainLimiter::measure(const Team& team, const Points& x) {
  if (empty()) return {};
  LimitReport report;
  const limit::Tables tables = elements_.tables();
  const limit::Motion motion{const_cast<double*>(x.data()), nullptr, options_.tolerance};
  look_.at_all(team, tables, motion);
  look_.tell(tables, motion, 1.0, report);
  return report;
}

bool StrainLimiter::enforce(const Team& team, std::uint64_t key, const limit::Tables& tables,
                            const limit::Motion& motion, LimitReport& report) {
  const bool randomly = options_.method == "gauss-seidel-random";
  Pending pending(elements_, tables, !options_.active_set, randomly);
  if (options_.active_set) {
    look_.at_all(team, tables, motion);
    report.evaluations += elements_.n_elements();
    bool any = false;
    for (Index b = 0; b < elements_.n_batches(); ++b)
      if (look_.excess(b) > motion.tolerance) pending.add(b), any = true;
    if (!any) {
      ++report.sweeps;
      return true;
    }
  }
  std::fill(corrected_.begin(), corrected_.end(), 0);
  while (report.sweeps < options_.max_sweeps) {
    std::int64_t n = 0;
    if (options_.method == "jacobi")
      n = sweep_jacobi(team, tables, motion, pending);
    else if (randomly)
      n = sweep_randomly(
          tables, motion,
          mixed(mixed(static_cast<std::uint64_t>(options_.seed), key), report.sweeps), pending);
    else
      n = sweep(team, tables, motion, report.sweeps, pending);
    ++report.sweeps;
    if (n == 0) break;  // every element that can be is within its limits
  }
  report.evaluations += pending.evaluations();
  if (options_.active_set) look_.at(team, tables, motion, pending.moved());
  return options_.active_set;
}

void StrainLimiter::run_batches(const Team& team, const limit::Tables& tables,
                                const limit::Motion& motion, const std::vector<Index>& batches) {
  parallel_ranges(
      team, static_cast<Index>(batches.size()), batches_per_range, [&](Index first, Index last) {
        if (deltas_.empty())
          limit::sweep(tables, motion, batches.data() + first, last - first, corrected_.data());
        else
          limit::corrections(tables, motion, batches.data() + first, last - first,
                             corrected_.data(), deltas_.data());
      });
}

// Tells what waits for it of all that was corrected in the batches; returns how much that is.
std::int64_t StrainLimiter::spread(const std::vector<Index>& batches, Pending& pending) const {
  std::int64_t corrected = 0;
  if (pending.everything()) {
    for (const Index b : batches) corrected += std::popcount(corrected_[b]);
    return corrected;
  }
  for (const Index b : batches)
    for (unsigned bits = corrected_[b]; bits != 0; bits &= bits - 1, ++corrected)
      pending.spread(8 * b + __builtin_ctz(bits));
  return corrected;
}

std::int64_t StrainLimiter::sweep(const Team& team, const limit::Tables& tables,
                                  const limit::Motion& motion, int number, Pending& pending) {
  const std::size_t n = pending.n_colours();
  std::int64_t corrected = 0;
  std::vector<Index> batches;
  for (std::size_t i = 0; i < n; ++i) {
    batches.clear();
    pending.take(number % 2 == 0 ? i : n - 1 - i, batches);  // there and back: less bias
    run_batches(team, tables, motion, batches);
    corrected += spread(batches, pending);
  }
  return corrected;
}

// Of what was corrected in the batches, each once: marked as listed until corrections are counted.
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

// What lies in one part of the mesh to one thread, which then mostly adds up what it has corrected
// itself; within a part as they are, which is how tables lie in memory.
std::vector<Index> StrainLimiter::divided(const Team& team,
                                          const std::vector<Index>& batches) const {
  if (team.threads <= 1) return batches;
  std::vector<std::vector<Index>> parts(team.threads);
  const auto last = static_cast<std::int64_t>(parts.size()) - 1;
  for (const Index b : batches)
    parts[std::min(last,
                   std::int64_t{elements_.element(8 * b)} * team.threads / elements_.n_elements())]
        .push_back(b);
  std::vector<Index> result;
  for (const std::vector<Index>& part : parts)
    result.insert(result.end(), part.begin(), part.end());
  return result;
}

// Corrections of an element scaled by one factor, one over the largest number of elements corrected
// at one of its vertices: the plain sum (3.17) diverges, and scaling per vertex would lose
// momentum.
std::int64_t StrainLimiter::sweep_jacobi(const Team& team, const limit::Tables& tables,
                                         const limit::Motion& motion, Pending& pending) {
  std::vector<Index> batches;
  for (std::size_t c = 0; c < pending.n_colours(); ++c) pending.take(c, batches);
  run_batches(team, tables, motion, divided(team, batches));
  const std::int64_t corrected = spread(batches, pending);
  if (corrected == 0) return 0;
  const auto& start = elements_.slot_start();
  const auto& slots = elements_.slots();
  const auto is_corrected = [&](Index slot) { return corrected_[slot / 8] >> (slot % 8) & 1; };
  const bool listed_alone =
      corrected < elements_.n_elements() / 8;  // else all vertices are looked at
  std::vector<Index> vertices;
  if (listed_alone) vertices = corners_of(batches);
  const Index n =
      listed_alone ? static_cast<Index>(vertices.size()) : static_cast<Index>(n_corrected_.size());
  parallel_for(team, n, [&](Index i) {
    const Index v = listed_alone ? vertices[i] : i;
    Index count = 0;
    for (Index s = start[v]; s < start[v + 1]; ++s) count += is_corrected(slots[s]);
    n_corrected_[v] = count;
  });
  double* const values = motion.v ? motion.v : motion.x;
  parallel_for(team, n, [&](Index i) {
    const Index v = listed_alone ? vertices[i] : i;
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
                                           std::uint64_t key, Pending& pending) {
  if (order_.empty())
    for (Index slot = 0; slot < 8 * elements_.n_batches(); ++slot)
      if (elements_.element(slot) >= 0) order_.push_back(slot);
  std::vector<Index> order = order_;
  Sequence random(key);
  for (Index i = static_cast<Index>(order.size()) - 1; i > 0; --i)
    std::swap(order[i], order[random.below(i + 1)]);
  std::int64_t corrected = 0;
  for (const Index slot : order)
    if (pending.take_one(slot) && limit::correct_one(tables, motion, slot)) {
      pending.spread(slot);
      ++corrected;
    }
  return corrected;
}

Vec3 corotational_strain(const Vec3& green) {
  const double c11 = 1.0 + 2.0 * green[0], c22 = 1.0 + 2.0 * green[1], c12 = 2.0 * green[2];
  const double d = std::sqrt(std::max(0.0, c11 * c22 - c12 * c12)),
               s = std::sqrt(c11 + c22 + 2.0 * d) + 1e-300;
  return {(c11 + d) / s - 1.0, (c22 + d) / s - 1.0, c12 / s};
}

Vec3 corotational_strain(const Triangles& triangles, const std::vector<Corners2>& corners,
                         const Points& x, Index triangle) {
  const Corners2& c = corners[triangle];
  const Vec2 e0 = (c.row(0) - c.row(2)).transpose(), e1 = (c.row(1) - c.row(2)).transpose();
  const double determinant = e0.x() * e1.y() - e0.y() * e1.x();
  limit::Element<double> element{};
  element.g0x = e1.y() / determinant, element.g0y = -e1.x() / determinant;
  element.g1x = -e0.y() / determinant, element.g1y = e0.x() / determinant;
  const auto corner = [&](int k) {
    const Index v = triangles(triangle, k);
    return limit::Space<double>{x(v, 0), x(v, 1), x(v, 2)};
  };
  const limit::Polar<double> p = limit::stretch(element, corner(0), corner(1), corner(2));
  return {p.u.a11 - 1.0, p.u.a22 - 1.0, p.u.a12};
}

void corotational_strain(const Team& team, const Triangles& triangles,
                         const std::vector<Corners2>& corners, const Points& x, Points& strain) {
  strain.resize(triangles.rows(), 3);
  parallel_for(team, static_cast<Index>(triangles.rows()), [&](Index t) {
    strain.row(t) = corotational_strain(triangles, corners, x, t).transpose();
  });
}

}  // namespace loomstone
