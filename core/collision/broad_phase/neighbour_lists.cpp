#include "core/collision/broad_phase/neighbour_lists.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <utility>

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
// The margin is 0.4 times the mean edge length, within these bounds [multiples of half the
// thickness]. Automatic steps are long, so accelerations move vertices far from their expected
// motion.
constexpr double margin_of_edge = 0.4, least_margin = 1.0, most_margin = 8.0;
// Lists are distributed again if the cost of one rank exceeds this multiple of the mean cost, but
// at most once in `least_updates` updates. Our choice.
constexpr double unbalanced = 1.25;
constexpr int least_updates = 8;
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

std::vector<Index> n_first_clusters(const std::vector<SurfacePair>& pairs,
                                    BroadPhase& broad_phase) {
  std::vector<Index> n;
  for (const SurfacePair& pair : pairs) n.push_back(broad_phase.tree(pair.a).n_clusters());
  return n;
}

}  // namespace

NeighbourLists::NeighbourLists(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                               BroadPhase& broad_phase, const Communicator& ranks,
                               std::size_t most_per_cluster)
    : model_(model),
      pairs_(pairs),
      broad_phase_(broad_phase),
      ranks_(ranks),
      most_per_cluster_(most_per_cluster),
      refit_(model, broad_phase, ranks),
      owners_(n_first_clusters(pairs, broad_phase), ranks),
      inflation_(model.surfaces.size(), 0.0),
      margin_(model.surfaces.size(), std::numeric_limits<double>::infinity()),
      still_(model.n_vertices),
      still_at_x_(model.n_vertices),
      vertices_(model.n_vertices),
      used_(model.surfaces.size()),
      motions_(model.surfaces.size()),
      marked_(model.surfaces.size()),
      unlisted_(pairs.size(), 0) {
  for (const SurfacePair& pair : pairs) {
    base_.push_back(std::max(pair.thickness, 1.02 * model.gap_floor));
    for (const Index s : {pair.a, pair.b})
      inflation_[s] = std::max(inflation_[s], 0.5 * base_.back() + rounding);
  }
}

bool NeighbourLists::updated_at(const Points& x) const {
  return x_.rows() == x.rows() && std::memcmp(x_.data(), x.data(), sizeof(double) * x.size()) == 0;
}

void NeighbourLists::find_slacks_and_margins(const Points& x) {
  for (const SurfacePair& pair : pairs_) {
    double sum = 0.0;
    Index n = 0;
    for (Index e = 0; e < model_.edges.rows(); ++e)
      if (const Index s = model_.surface_of_edge[e]; s == pair.a) {
        sum += (x.row(model_.edges(e, 0)) - x.row(model_.edges(e, 1))).norm();
        ++n;
      }
    const double mean = n > 0 ? sum / n : 0.0;
    most_slack_.push_back(std::max(most_slack * pair.thickness, most_slack_of_edge * mean));
    for (const Index s : {pair.a, pair.b}) margin_[s] = std::min(margin_[s], margin_of_edge * mean);
  }
  for (std::size_t s = 0; s < margin_.size(); ++s)
    margin_[s] = std::clamp(margin_[s], least_margin * inflation_[s], most_margin * inflation_[s]);
}

// Finds the motions of the clusters in the lists of this rank.
void NeighbourLists::find_motions(const Team& team, const Points& x0, const Points& x1) {
  for (std::size_t s = 0; s < used_.size(); ++s) {
    const std::vector<Index>& used = used_[s];
    const ClusterMembers& members = refit_.members(static_cast<Index>(s));
    parallel_for(
        team, static_cast<Index>(used.size()),
        [&](Index i) { motions_[s][used[i]] = cluster_motion(members, used[i], x0, x1); }, 256);
  }
}

double NeighbourLists::change_bound(const NeighbourList& list) const {
  const ClusterMotion &a = motions_[pairs_[list.pair].a][list.a],
                      &b = motions_[pairs_[list.pair].b][list.b];
  return (a.radius + b.radius + (a.centre - b.centre).norm()) * (1.0 + 1e-12) + rounding;
}

// Returns whether the vertices that this rank checks are within the margin of their expected
// motion, at x and at x + ahead * (x - before_).
bool NeighbourLists::as_expected(const Team& team, const Points& x, double ahead) const {
  const IndexRange share = even_share(model_.n_vertices, ranks_.rank(), ranks_.size());
  std::atomic<bool> all{true};
  for (std::size_t s = 0; s < model_.surfaces.size(); ++s) {
    const CollisionSurface& surface = model_.surfaces[s];
    const double most = margin_[s] - rounding, most2 = most * most;
    const Index first = std::max(surface.first_vertex, share.begin),
                last = std::min(surface.first_vertex + surface.n_vertices, share.end);
    if (first >= last) continue;
    parallel_ranges(team, last - first, 2048, [&](Index begin, Index end) {
      bool near = true;
      for (Index v = first + begin; v < first + end; ++v) {
        const Eigen::RowVector3d along = to_.row(v) - from_.row(v);
        const double length2 = std::max(along.squaredNorm(), 1e-300);
        const auto expected = [&](const Eigen::RowVector3d& offset) {
          const double share_of_motion = std::clamp(offset.dot(along) / length2, 0.0, 1.0);
          return (offset - share_of_motion * along).squaredNorm() <= most2;
        };
        near &= expected(x.row(v) - from_.row(v));
        if (ahead > 0.0)
          near &= expected(x.row(v) + ahead * (x.row(v) - before_.row(v)) - from_.row(v));
      }
      if (!near) all = false;
    });
  }
  return all;
}

// Distributes the lists over the ranks so that an update costs about the same on each rank. Lists
// that move to another rank are made again there.
void NeighbourLists::distribute() {
  if (owners_.rotates()) return owners_.rotate();
  if (updates_ == 0 || ranks_.size() == 1) return;
  std::vector<float> costs(owners_.n_own(), 0.0f);
  for (NeighbourList& list : lists_) {
    costs[owners_.own_index(list.pair, list.a)] += list.cost / static_cast<float>(updates_);
    list.cost = 0.0f;
  }
  updates_ = 0;
  owners_.cut(costs);
}

// Finds the pairs of clusters that come near each other while vertices move from the positions of
// the last update() towards x1. The motion is extrapolated over `steps_ahead` steps.
void NeighbourLists::search(const Team& team, const Points& x1) {
  ++n_searches_;
  distribute();
  from_ = x_;
  to_ = x_ + steps_ahead * (x1 - x_);
  const std::vector<std::uint8_t> formed = refit_.refit(
      team, x_,
      [&](Index s, Index v) {
        const std::size_t at = 3 * static_cast<std::size_t>(v);
        return packed(slabs_of(from_.data() + at, to_.data() + at, inflation_[s] + margin_[s]));
      },
      n_searches_ % 8 == 0);
  for (std::size_t s = 0; s < formed.size(); ++s) {
    if (formed[s]) motions_[s].resize(refit_.members(static_cast<Index>(s)).n_clusters());
    marked_[s].assign(motions_[s].size(), 0);
  }

  std::vector<std::vector<PairKey>> found(pairs_.size());
  const auto most = [&](Index i) {
    return most_per_cluster_ * (motions_[pairs_[i].a].size() + motions_[pairs_[i].b].size());
  };
  const Gathered<std::size_t> counts = gather_from_ranks(ranks_, [&] {
    std::vector<std::size_t> n;
    for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i) {
      if (!unlisted_[i]) found[i] = broad_phase_.cluster_pairs(team, i, owners_.own(i), most(i));
      n.push_back(found[i].size());
    }
    return n;
  });
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    std::size_t n = 0;
    for (std::size_t k = i; k < counts.elements.size(); k += pairs_.size()) n += counts.elements[k];
    if (n > most(static_cast<Index>(i))) unlisted_[i] = 1;
  }
  keep_or_add(found, formed);
  find_used();
}

// Replaces the lists by those of the cluster pairs in `found`. Keeps existing lists of surfaces
// whose clusters have not been formed again.
void NeighbourLists::keep_or_add(const std::vector<std::vector<PairKey>>& found,
                                 const std::vector<std::uint8_t>& formed) {
  std::vector<NeighbourList> old;
  old.swap(lists_);
  lists_.reserve(old.size() + old.size() / 8);
  std::size_t next = 0;
  for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i) {
    if (unlisted_[i]) continue;
    const SurfacePair& pair = pairs_[i];
    const bool known = !formed[pair.a] && !formed[pair.b];
    for (const PairKey clusters : found[i]) {
      while (next < old.size() && before(old[next], i, clusters)) ++next;
      if (known && next < old.size() && old[next].pair == i &&
          pair_key(old[next].a, old[next].b) == clusters)
        lists_.push_back(std::move(old[next++]));
      else
        lists_.push_back({.pair = i, .a = first_of(clusters), .b = second_of(clusters)});
    }
  }
}

// Finds the clusters and vertices in the lists of this rank.
void NeighbourLists::find_used() {
  for (std::vector<Index>& used : used_) used.clear();
  vertices_.clear();
  const auto use = [&](Index surface, Index cluster) {
    if (marked_[surface][cluster]) return;
    marked_[surface][cluster] = 1;
    used_[surface].push_back(cluster);
    refit_.members(surface).each(cluster, [&](Index v) { vertices_.add(v); });
  };
  for (const NeighbourList& list : lists_) {
    use(pairs_[list.pair].a, list.a);
    use(pairs_[list.pair].b, list.b);
  }
  for (std::size_t s = 0; s < used_.size(); ++s)
    for (const Index c : used_[s]) marked_[s][c] = 0;
}

void NeighbourLists::make(NeighbourList& list, PairSearch::Slots& slots) const {
  const WorkTimer<float> timing = timer(list);
  const SurfacePair& pair = pairs_[list.pair];
  const ClusterTree &a = broad_phase_.tree(pair.a), &b = broad_phase_.tree(pair.b);
  const double base = base_[list.pair];
  const double wanted =
      std::clamp(steps_to_last * list.change, least_slack * pair.thickness, most_slack_[list.pair]);
  list.slack = std::max(wanted, 1.5 * list.change);
  list.used = 0.0;
  list.cost += ListCosts::made;
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
  list.cost += ListCosts::made_pair * static_cast<float>(list.near.size());
}

void NeighbourLists::make_ended(const Team& team) {
  std::vector<Index> which;
  for (std::size_t i = 0; i < ended_.size(); ++i)
    if (ended_[i]) which.push_back(static_cast<Index>(i));
  if (which.empty()) return;
  n_made_ += static_cast<std::int64_t>(which.size());
  const std::size_t n_known = still_at_x_.vertices().size();
  const auto mark = [&](Index surface, Index cluster) {
    if (marked_[surface][cluster]) return;
    marked_[surface][cluster] = 1;
    refit_.members(surface).each(cluster, [&](Index v) { still_at_x_.add(v); });
  };
  for (const Index i : which) {
    mark(pairs_[lists_[i].pair].a, lists_[i].a);
    mark(pairs_[lists_[i].pair].b, lists_[i].b);
  }
  const std::vector<Index>& vertices = still_at_x_.vertices();
  parallel_for(
      team, static_cast<Index>(vertices.size() - n_known),
      [&](Index i) {
        const Index v = vertices[n_known + i];
        const double* const at = x_.data() + 3 * static_cast<std::size_t>(v);
        still_[v] = packed(slabs_of(at, at, 0.0));
      },
      2048);
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
  ended_.assign(lists_.size(), 0);
}

void NeighbourLists::update(const Team& team, const Points& x) {
  const bool first = x_.rows() != x.rows();
  bool again = first || refit_.other_trees();
  if (again) lists_.clear(), ended_.clear();
  if (first) x_ = x, find_slacks_and_margins(x);
  before_.swap(x_);
  x_ = x;
  still_at_x_.clear();
  ++updates_;
  // The negated comparisons are also true for NaN.
  const auto ends = [&](const NeighbourList& list) {
    return !(list.used <= list.slack) ||
           !(list.used + list.change <= list.slack + spare(list.pair));
  };
  std::vector<Pass> passes;
  if (!again) {
    const bool all_listed = unlisted().empty();
    passes = results_of_ranks(ranks_, [&] {
      const WorkTimer<double> timing(pass_seconds_, clock_);
      find_motions(team, before_, x);
      parallel_for(team, static_cast<Index>(lists_.size()), [&](Index i) {
        lists_[i].change = change_bound(lists_[i]);
        lists_[i].used += lists_[i].change;
      });
      Pass pass = find_ended(team, ends);
      pass.unexpected = !all_listed || !as_expected(team, x, 1.0);
      return pass;
    });
    again = search_is_due(passes);
  }
  if (again) {
    std::fill(unlisted_.begin(), unlisted_.end(), 0);
    const Points ahead = 2.0 * x - before_;  // extrapolates the last step
    search(team, ahead);
    passes = results_of_ranks(ranks_, [&] {
      find_motions(team, x, ahead);
      parallel_for(team, static_cast<Index>(lists_.size()),
                   [&](Index i) { lists_[i].change = change_bound(lists_[i]); });
      return find_ended(team, ends);
    });
  }
  unlist_fast(passes);
}

void NeighbourLists::cover(const Team& team, const Points& x1) {
  const auto pass_to_x1 = [&] {
    const WorkTimer<double> timing(pass_seconds_, clock_);
    find_motions(team, x_, x1);
    parallel_for(team, static_cast<Index>(lists_.size()),
                 [&](Index i) { lists_[i].change = change_bound(lists_[i]); });
    return find_ended(team, [&](const NeighbourList& list) {
      return !(list.slack >= 0.0) || !(list.used + list.change <= list.slack + spare(list.pair));
    });
  };
  bool again = refit_.other_trees();
  std::vector<Pass> passes;
  if (again) {
    lists_.clear(), ended_.clear();
  } else {
    const bool any_listed = unlisted().size() < pairs_.size();
    passes = results_of_ranks(ranks_, [&] {
      make_ended(team);
      Pass pass = pass_to_x1();
      pass.unexpected = any_listed && !as_expected(team, x1, 0.0);
      return pass;
    });
    for (const Pass& pass : passes) again = again || pass.unexpected;
  }
  if (again) {
    search(team, x1);
    passes = results_of_ranks(ranks_, pass_to_x1);
  }
  unlist_fast(passes);
}

// Returns whether vertices have left their expected motion on some rank, whether costs are
// unbalanced, or whether every search changes the owners.
bool NeighbourLists::search_is_due(const std::vector<Pass>& passes) const {
  double most = 0.0, sum = 0.0;
  for (const Pass& pass : passes) {
    if (pass.unexpected) return true;
    most = std::max(most, pass.cost);
    sum += pass.cost;
  }
  return owners_.rotates() ||
         (updates_ >= least_updates && most * ranks_.size() > unbalanced * sum);
}

// Finds the lists of this rank for which `ends` is true.
template <class Ends>
NeighbourLists::Pass NeighbourLists::find_ended(const Team& team, Ends&& ends) {
  constexpr Index grain = 1024;
  const Index n = static_cast<Index>(lists_.size());
  ended_.assign(n, 0);
  std::vector<Pass> of_range((n + grain - 1) / grain);
  parallel_ranges(team, n, grain, [&](Index begin, Index end) {
    Pass& pass = of_range[begin / grain];
    for (Index i = begin; i < end; ++i) {
      const NeighbourList& list = lists_[i];
      pass.fast |= list.change > most_slack_[list.pair];
      pass.cost += list.cost;
      ended_[i] = ends(list);
    }
  });
  Pass all;
  for (const Pass& pass : of_range) all.fast |= pass.fast, all.cost += pass.cost;
  return all;
}

// Makes a surface pair unlisted if more than a quarter of its lists on all ranks have a `change`
// above the largest slack.
void NeighbourLists::unlist_fast(const std::vector<Pass>& passes) {
  if (std::none_of(passes.begin(), passes.end(), [](const Pass& pass) { return pass.fast; }))
    return;
  const Gathered<Counts> counts = gather_from_ranks(ranks_, [&] {
    std::vector<Counts> own(pairs_.size());
    for (const NeighbourList& list : lists_) {
      ++own[list.pair].lists;
      own[list.pair].fast += list.change > most_slack_[list.pair];
    }
    return own;
  });
  bool any = false;
  for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
    Counts sum;
    for (std::size_t k = pair; k < counts.elements.size(); k += pairs_.size())
      sum.lists += counts.elements[k].lists, sum.fast += counts.elements[k].fast;
    if (sum.fast > sum.lists / 4) unlisted_[pair] = 1, any = true;
  }
  if (!any) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < lists_.size(); ++i) {
    if (unlisted_[lists_[i].pair]) continue;
    ended_[kept] = ended_[i];
    if (kept != i) lists_[kept] = std::move(lists_[i]);
    ++kept;
  }
  lists_.erase(lists_.begin() + static_cast<std::ptrdiff_t>(kept), lists_.end());
  ended_.resize(kept);
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
    const WorkTimer<double> timing = unlisted_timer();
    std::vector<double> reach;
    for (const SurfacePair& pair : pairs_) reach.push_back(pair.thickness + rounding);
    broad_phase_.near_pairs(team, x_, which, reach, found);
  }
  return found;
}

std::size_t NeighbourLists::bytes() const {
  return bytes_of(refit_, owners_, base_, most_slack_, inflation_, x_, before_, from_, to_,
                  still_) +
         bytes_of(still_at_x_, vertices_, used_, motions_, marked_, lists_, ended_, unlisted_);
}

}  // namespace loomstone
