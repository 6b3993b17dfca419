#include "core/collision/broad_phase/neighbour_lists.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "core/collision/narrow_phase/distance.h"

namespace loomstone {

namespace {

// Parameters tuned on a draped sheet; they affect speed only. The slack of a list covers
// `steps_to_last` steps of the current motion, within the bounds below. In the search for cluster
// pairs, vertex boxes cover `steps_ahead` steps plus `margin`.
constexpr double steps_to_last = 12.0;
constexpr double least_slack = 0.2, most_slack = 2.5;  // as fractions of the thickness
constexpr double most_slack_of_edge = 0.6;             // as a fraction of the mean edge length
constexpr double steps_ahead = 3.0;
constexpr double margin = 1.0;  // as a fraction of half the thickness
// Allowance for rounding errors, which accumulate as bounds are summed over steps [m].
constexpr double rounding = 1e-12;

// Returns a lower bound of the distance between two boxes [m].
double gap_between(const PackedSlabs& a, const PackedSlabs& b) {
  double square = 0.0, diagonal = 0.0;
  for (int k = 0; k < n_slabs; ++k) {
    const int high = n_slabs + k;  // upper bounds are stored with the opposite sign
    const double gap = std::max({static_cast<double>(a.value[k]) + b.value[high],
                                 static_cast<double>(b.value[k]) + a.value[high], 0.0});
    if (k < n_axis_slabs)
      square += gap * gap;
    else
      diagonal = std::max(diagonal, gap);
  }
  return std::max(std::sqrt(square), diagonal / 1.4142135623730952) * (1.0 - 1e-12) - rounding;
}

bool before(const NeighbourList& list, Index pair, PairKey clusters) {
  return list.pair != pair ? list.pair < pair : pair_key(list.a, list.b) < clusters;
}

}  // namespace

NeighbourLists::NeighbourLists(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                               BroadPhase& broad_phase, std::size_t most_per_cluster)
    : model_(model),
      pairs_(pairs),
      broad_phase_(broad_phase),
      most_per_cluster_(most_per_cluster),
      inflation_(model.surfaces.size(), 0.0),
      version_(model.surfaces.size(), 0),
      members_(model.surfaces.size()),
      motions_(model.surfaces.size()),
      marked_(model.surfaces.size()),
      unlisted_(pairs.size(), 0) {
  for (const SurfacePair& pair : pairs) {
    base_.push_back(std::max(pair.thickness, 1.02 * model.gap_floor));
    for (const Index s : {pair.a, pair.b})
      inflation_[s] = std::max(inflation_[s], 0.5 * base_.back() + rounding);
  }
}

double NeighbourLists::margin_of(Index surface) const { return margin * inflation_[surface]; }

bool NeighbourLists::updated_at(const Points& x) const {
  return x_.rows() == x.rows() && std::memcmp(x_.data(), x.data(), sizeof(double) * x.size()) == 0;
}

bool NeighbourLists::other_trees() const {
  for (std::size_t s = 0; s < version_.size(); ++s)
    if (broad_phase_.tree(static_cast<Index>(s)).version() != version_[s]) return true;
  return false;
}

void NeighbourLists::find_members(Index surface) {
  const ClusterTree& tree = broad_phase_.tree(surface);
  const Index* const corners = tree.faces().corners.data();
  Members& members = members_[surface];
  members.start.assign(1, 0);
  members.vertices.clear();
  for (Index c = 0; c < tree.n_clusters(); ++c) {
    const auto begin = members.vertices.insert(members.vertices.end(), corners + 3 * slab_lanes * c,
                                               corners + 3 * slab_lanes * (c + 1));
    std::sort(begin, members.vertices.end());
    members.vertices.erase(std::unique(begin, members.vertices.end()), members.vertices.end());
    const auto none = members.vertices.begin() + members.start.back();  // empty lanes sort first
    if (none != members.vertices.end() && *none < 0) members.vertices.erase(none);
    members.start.push_back(static_cast<Index>(members.vertices.size()));
  }
}

void NeighbourLists::find_motions(const Team& team, const Points& x0, const Points& x1) {
  for (std::size_t s = 0; s < motions_.size(); ++s) {
    const Members& members = members_[s];
    const Index n_clusters = static_cast<Index>(members.start.size()) - 1;
    motions_[s].resize(n_clusters);
    parallel_for(
        team, n_clusters,
        [&](Index c) {
          double low[3] = {INFINITY, INFINITY, INFINITY},
                 high[3] = {-INFINITY, -INFINITY, -INFINITY};
          for (Index i = members.start[c]; i < members.start[c + 1]; ++i) {
            const Index v = members.vertices[i];
            for (int k = 0; k < 3; ++k) {
              const double d = x1(v, k) - x0(v, k);
              low[k] = std::min(low[k], d);
              high[k] = std::max(high[k], d);
            }
          }
          Motion& motion = motions_[s][c];
          double square = 0.0;
          for (int k = 0; k < 3; ++k) {
            motion.centre[k] = 0.5 * (low[k] + high[k]);
            square += 0.25 * (high[k] - low[k]) * (high[k] - low[k]);
          }
          motion.radius = std::sqrt(square);
        },
        256);
  }
}

double NeighbourLists::change_bound(const NeighbourList& list) const {
  const Motion &a = motions_[pairs_[list.pair].a][list.a],
               &b = motions_[pairs_[list.pair].b][list.b];
  return (a.radius + b.radius + (a.centre - b.centre).norm()) * (1.0 + 1e-12) + rounding;
}

// Returns whether all vertices at x are within the margin of their expected motion.
bool NeighbourLists::as_expected(const Team& team, const Points& x) const {
  std::atomic<bool> all{true};
  for (std::size_t s = 0; s < model_.surfaces.size(); ++s) {
    const CollisionSurface& surface = model_.surfaces[s];
    const double most = margin_of(static_cast<Index>(s)) - rounding, most2 = most * most;
    parallel_ranges(team, surface.n_vertices, 2048, [&](Index begin, Index end) {
      bool near = true;
      for (Index v = surface.first_vertex + begin; v < surface.first_vertex + end; ++v) {
        const Eigen::RowVector3d along = to_.row(v) - from_.row(v),
                                 offset = x.row(v) - from_.row(v);
        const double share =
            std::clamp(offset.dot(along) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0);
        near &= (offset - share * along).squaredNorm() <= most2;
      }
      if (!near) all = false;
    });
  }
  return all;
}

// Computes the vertex boxes at the positions of the last update().
void NeighbourLists::pack_still(const Team& team) {
  if (still_at_x_) return;
  still_.resize(model_.n_vertices);
  parallel_for(
      team, model_.n_vertices,
      [&](Index v) {
        const double* const at = x_.data() + 3 * static_cast<std::size_t>(v);
        still_[v] = packed(slabs_of(at, at, 0.0));
      },
      2048);
  still_at_x_ = true;
}

// Finds the pairs of clusters that come near each other while vertices move from the positions of
// the last update() towards x1. The motion is extrapolated over `steps_ahead` steps.
void NeighbourLists::search(const Team& team, const Points& x1) {
  ++n_searches_;
  pack_still(team);
  moving_.resize(model_.n_vertices);
  from_ = x_;
  to_ = x_ + steps_ahead * (x1 - x_);
  std::vector<std::uint8_t> formed(model_.surfaces.size(), 0);
  for (std::size_t s = 0; s < model_.surfaces.size(); ++s) {
    const CollisionSurface& surface = model_.surfaces[s];
    parallel_for(
        team, surface.n_vertices,
        [&](Index i) {
          const std::size_t v = surface.first_vertex + i;
          const double *from = from_.data() + 3 * v, *to = to_.data() + 3 * v;
          moving_[v] = packed(slabs_of(from, to, inflation_[s] + margin_of(static_cast<Index>(s))));
        },
        1024);
    ClusterTree& tree = broad_phase_.tree(static_cast<Index>(s));
    tree.refit_nodes(team, x_, still_, moving_, n_searches_ % 8 == 0);
    formed[s] = tree.version() != version_[s];
    version_[s] = tree.version();
    if (formed[s]) find_members(static_cast<Index>(s));
    marked_[s].assign(tree.n_clusters(), 0);
  }

  std::vector<NeighbourList> old;
  old.swap(lists_);
  lists_.reserve(old.size() + old.size() / 8);
  std::size_t next = 0;
  std::vector<PairKey> found;
  for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i) {
    const SurfacePair& pair = pairs_[i];
    const std::size_t n_clusters =
        broad_phase_.tree(pair.a).n_clusters() + broad_phase_.tree(pair.b).n_clusters();
    if (!unlisted_[i])
      unlisted_[i] = !broad_phase_.cluster_pairs(team, i, most_per_cluster_ * n_clusters, found);
    if (unlisted_[i]) continue;
    const bool known = !formed[pair.a] && !formed[pair.b];
    for (const PairKey clusters : found) {
      while (next < old.size() && before(old[next], i, clusters)) ++next;
      if (known && next < old.size() && old[next].pair == i &&
          pair_key(old[next].a, old[next].b) == clusters)
        lists_.push_back(std::move(old[next++]));
      else
        lists_.push_back({.pair = i, .a = first_of(clusters), .b = second_of(clusters)});
    }
  }
}

void NeighbourLists::make(NeighbourList& list, PairSearch::Slots& slots) const {
  const SurfacePair& pair = pairs_[list.pair];
  const ClusterTree &a = broad_phase_.tree(pair.a), &b = broad_phase_.tree(pair.b);
  const double base = base_[list.pair];
  const double wanted =
      std::clamp(steps_to_last * list.change, least_slack * pair.thickness, most_slack_[list.pair]);
  list.slack = std::max(wanted, 1.5 * list.change);
  list.used = 0.0;
  list.near.clear();
  list.n_vertex_face = 0;
  list.nearest = std::numeric_limits<double>::infinity();
  if (&a != &b || list.a != list.b) {
    const double gap = gap_between(a.box(list.a), b.box(list.b));
    if (gap > base + list.slack) {
      list.slack = gap - base;
      return;
    }
  }
  const double reach = base + list.slack;
  PairSearch(a, b).features(
      list.a, list.b, reach + rounding, slots, [&](ContactKind kind, Index first, Index second) {
        const PairKey key = pair_key(first, second);
        if (broad_phase_.attached(kind, key)) return;
        const std::array<Index, 4> v = pair_vertices(model_, kind, key);
        FourPoints p;
        for (int k = 0; k < 4; ++k) p[k] = x_.row(v[k]).transpose();
        const double distance = distance_within(kind == ContactKind::VertexFace, p, reach);
        if (!(distance <= reach)) return;
        list.near.push_back({key, distance});
        list.n_vertex_face += kind == ContactKind::VertexFace;
        list.nearest = std::min(list.nearest, distance);
      });
}

void NeighbourLists::make(const Team& team, const std::vector<Index>& which) {
  if (which.empty()) return;
  n_made_ += static_cast<std::int64_t>(which.size());
  pack_still(team);
  for (const Index i : which) {
    const NeighbourList& list = lists_[i];
    marked_[pairs_[list.pair].a][list.a] = marked_[pairs_[list.pair].b][list.b] = 1;
  }
  for (std::size_t s = 0; s < marked_.size(); ++s) {
    ClusterTree& tree = broad_phase_.tree(static_cast<Index>(s));
    tree.refit_features_of(team, marked_[s], still_);
    std::fill(marked_[s].begin(), marked_[s].end(), 0);
  }
  constexpr Index at_once = 32;
  const Index n = static_cast<Index>(which.size());
  parallel_tasks(team, (n + at_once - 1) / at_once, [&](Index task) {
    PairSearch::Slots slots;
    for (Index i = task * at_once; i < std::min(n, (task + 1) * at_once); ++i)
      make(lists_[which[i]], slots);
  });
}

void NeighbourLists::update(const Team& team, const Points& x) {
  const bool first = x_.rows() != x.rows();
  bool again = first || other_trees();
  if (again) lists_.clear();
  if (first) x_ = x;
  const Points before = std::move(x_);
  x_ = x;
  still_at_x_ = false;
  if (first) {
    most_slack_.clear();
    for (const SurfacePair& pair : pairs_) {
      double sum = 0.0;
      Index n = 0;
      for (Index e = 0; e < model_.edges.rows(); ++e)
        if (const Index s = model_.surface_of_edge[e]; s == pair.a) {
          sum += (x.row(model_.edges(e, 0)) - x.row(model_.edges(e, 1))).norm();
          ++n;
        }
      most_slack_.push_back(
          std::max(most_slack * pair.thickness, n > 0 ? most_slack_of_edge * sum / n : 0.0));
    }
  }
  const Points ahead = 2.0 * x - before;  // extrapolates the last step
  if (!again) {
    find_motions(team, before, x);
    parallel_for(team, static_cast<Index>(lists_.size()), [&](Index i) {
      lists_[i].change = change_bound(lists_[i]);
      lists_[i].used += lists_[i].change;
    });
    again = !unlisted().empty() || !as_expected(team, ahead) || !as_expected(team, x);
  }
  if (again) {
    std::fill(unlisted_.begin(), unlisted_.end(), 0);
    search(team, ahead);
    find_motions(team, x, ahead);
    parallel_for(team, static_cast<Index>(lists_.size()),
                 [&](Index i) { lists_[i].change = change_bound(lists_[i]); });
  }
  // The negated comparisons are also true for NaN.
  make(team, ended(team, [&](const NeighbourList& list) {
         return !(list.used <= list.slack) ||
                !(list.used + list.change <= list.slack + spare(list.pair));
       }));
}

void NeighbourLists::cover(const Team& team, const Points& x1) {
  const bool others = other_trees();
  if (others) lists_.clear();
  if (others || (unlisted().size() < pairs_.size() && !as_expected(team, x1))) search(team, x1);
  find_motions(team, x_, x1);
  parallel_for(team, static_cast<Index>(lists_.size()),
               [&](Index i) { lists_[i].change = change_bound(lists_[i]); });
  make(team, ended(team, [&](const NeighbourList& list) {
         return !(list.slack >= 0.0) || !(list.used + list.change <= list.slack + spare(list.pair));
       }));
}

// Returns the indices of the lists for which `ends` is true. First makes a surface pair unlisted if
// more than a quarter of its lists have a `change` above the largest slack.
template <class Ends>
std::vector<Index> NeighbourLists::ended(const Team& team, Ends&& ends) {
  constexpr Index grain = 1024;
  struct Seen {
    std::vector<Index> ended;
    std::vector<std::size_t> n_lists, n_fast;  // counts for each surface pair
  };
  const Index n = static_cast<Index>(lists_.size());
  std::vector<Seen> of_range((n + grain - 1) / grain);
  parallel_tasks(team, static_cast<Index>(of_range.size()), [&](Index range) {
    Seen& seen = of_range[range];
    seen.n_lists.assign(pairs_.size(), 0), seen.n_fast.assign(pairs_.size(), 0);
    for (Index i = range * grain; i < std::min(n, (range + 1) * grain); ++i) {
      const NeighbourList& list = lists_[i];
      ++seen.n_lists[list.pair];
      seen.n_fast[list.pair] += list.change > most_slack_[list.pair];
      if (ends(list)) seen.ended.push_back(i);
    }
  });
  bool any = false;
  for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
    std::size_t n_lists = 0, n_fast = 0;
    for (const Seen& seen : of_range) n_lists += seen.n_lists[pair], n_fast += seen.n_fast[pair];
    if (n_fast > n_lists / 4) unlisted_[pair] = 1, any = true;
  }
  if (any) {
    std::erase_if(lists_, [&](const NeighbourList& list) { return unlisted_[list.pair] != 0; });
    return ended(team, ends);
  }
  std::vector<Index> all;
  for (const Seen& seen : of_range) all.insert(all.end(), seen.ended.begin(), seen.ended.end());
  return all;
}

std::vector<Index> NeighbourLists::unlisted() const {
  std::vector<Index> which;
  for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i)
    if (unlisted_[i]) which.push_back(i);
  return which;
}

std::vector<FeaturePairs> NeighbourLists::unlisted_near_pairs(const Team& team) const {
  std::vector<FeaturePairs> found(pairs_.size());
  if (const std::vector<Index> which = unlisted(); !which.empty()) {
    std::vector<double> reach;
    for (const SurfacePair& pair : pairs_) reach.push_back(pair.thickness + rounding);
    broad_phase_.near_pairs(team, x_, which, reach, found);
  }
  return found;
}

}  // namespace loomstone
