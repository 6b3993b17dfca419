#include "core/collision/broad_phase/neighbour_lists.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/same_bits.h"
#include "core/collision/narrow_phase/distance.h"

namespace loomstone {

namespace {

// Parameters tuned on a draped sheet; they affect speed only. The slack of a list is the change of
// distances over `steps_to_last` steps of the current motion. It is at least `least_slack` times
// the thickness, and at most the larger of `most_slack` times the thickness and
// `most_slack_of_edge` times the mean edge length of the first surface of the pair. But it is never
// less than the change over 1.5 steps. If the boxes of the two clusters are farther apart than the
// base distance plus this slack, the slack is increased to the gap between the boxes minus the base
// distance. In the search for cluster pairs, vertex boxes cover the motion over `steps_ahead` steps
// plus a margin.
constexpr double steps_to_last = 12.0;
constexpr double least_slack = 0.2, most_slack = 2.5;
constexpr double most_slack_of_edge = 0.6;
constexpr double steps_ahead = 3.0;
// The margin of a surface pair is `margin_of_edge` times the mean edge length of its first surface.
// A surface uses the smallest margin of its pairs, clamped to the range from `least_margin` to
// `most_margin` times its inflation_.
constexpr double margin_of_edge = 0.4, least_margin = 1.0, most_margin = 8.0;

// Returns a lower bound on the distance between two boxes [m].
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
  return std::max(std::sqrt(square), diagonal / 1.4142135623730952) * (1.0 - 1e-12);
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
      still_at_x_(model.n_vertices),
      vertices_(model.n_vertices),
      used_(model.surfaces.size()),
      motions_(model.surfaces.size()),
      marked_(model.surfaces.size()),
      unlisted_(pairs.size(), 0),
      n_lists_(pairs.size(), 0),
      upkeep_(pairs.size()) {
  find_bases();
}

void NeighbourLists::find_bases() {
  base_.clear();
  for (const SurfacePair& pair : pairs_) {
    base_.push_back(std::max(pair.thickness + extra_, 1.02 * model_.gap_floor));
    for (const Index s : {pair.a, pair.b})
      inflation_[s] = std::max(inflation_[s], 0.5 * base_.back() + rounding);
  }
}

void NeighbourLists::widen(double extra) {
  if (extra <= extra_) return;
  extra_ = extra;
  find_bases();
  x_.resize(0, 3);  // the next update makes all lists again
}

bool NeighbourLists::updated_at(const Points& x) const { return same_bits(x_, x); }

void NeighbourLists::find_slacks_and_margins(const Points& x) {
  most_slack_.clear();
  std::fill(margin_.begin(), margin_.end(), std::numeric_limits<double>::infinity());
  for (const SurfacePair& pair : pairs_) {
    double sum = 0.0;
    Index n = 0;
    for (Index e = 0; e < model_.edges.rows(); ++e)
      if (const Index s = model_.surface_of_edge(e); s == pair.a) {
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

// Finds the motions from x0 to x1 of all clusters in the lists of this rank.
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

// Distributes the lists over the ranks so that the work on them takes about the same time on each
// rank. Lists that move to another rank are made again there.
void NeighbourLists::distribute() {
  if (owners_.rotates()) return owners_.rotate();
  if (updates_ == 0 || ranks_.size() == 1) return;
  std::vector<float> costs(owners_.n_own(), 0.0f);
  for (NeighbourList& list : lists_) {
    costs[owners_.own_index(list.pair, list.a)] += list.spent / static_cast<float>(updates_);
    list.cost = list.spent = 0.0f;
  }
  updates_ = 0;
  owners_.cut(costs);
}

// Distributes the lists over the ranks. Then finds the pairs of clusters that come near each other
// while vertices move from the positions of the last update() towards x1, and gives each of these
// pairs a list on one rank. The motion is extrapolated over `steps_ahead` steps. Unlists surface
// pairs with too many cluster pairs. May form new clusters in every eighth search, and in any
// search if `may_rebuild` is set.
void NeighbourLists::search(const Team& team, const Points& x1, bool may_rebuild) {
  ++n_searches_;
  settled_ = false;
  distribute();
  from_ = own_rows(x_);
  to_ = own_rows(x_) + steps_ahead * (own_rows(x1) - own_rows(x_));
  const std::vector<std::uint8_t> formed = refit_.refit(
      team, x_,
      [&](Index s, Index v) {
        const Eigen::RowVector3d to = x_.row(v) + steps_ahead * (x1.row(v) - x_.row(v));
        return packed(slabs_of(x_.row(v).data(), to.data(), inflation_[s] + margin_[s]));
      },
      may_rebuild || n_searches_ % 8 == 0);
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
      if (listed(i)) found[i] = broad_phase_.cluster_pairs(team, i, owners_.own(i), most(i));
      n.push_back(found[i].size());
    }
    return n;
  });
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    std::size_t n = 0;
    for (std::size_t k = i; k < counts.elements.size(); k += pairs_.size()) n += counts.elements[k];
    if (n > most(static_cast<Index>(i))) unlist(i);
  }
  keep_or_add(found, formed);
  find_used();
}

// Replaces the lists of this rank by those of the cluster pairs in `found`, except for unlisted
// surface pairs. Keeps the existing list of such a cluster pair unless the clusters of one of the
// two surfaces have been formed again (`formed`).
void NeighbourLists::keep_or_add(const std::vector<std::vector<PairKey>>& found,
                                 const std::vector<std::uint8_t>& formed) {
  std::vector<NeighbourList> old;
  old.swap(lists_);
  std::size_t n = 0, next = 0;
  for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i)
    n += listed(i) ? found[i].size() : 0;
  lists_.reserve(n);
  for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i) {
    if (!listed(i)) continue;
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

// Finds the clusters and vertices in the lists of this rank, and counts the lists of each surface
// pair.
void NeighbourLists::find_used() {
  for (std::vector<Index>& used : used_) used.clear();
  vertices_.clear();
  const auto use = [&](Index surface, Index cluster) {
    if (marked_[surface][cluster]) return;
    marked_[surface][cluster] = 1;
    used_[surface].push_back(cluster);
    refit_.members(surface).each(cluster, [&](Index v) { vertices_.add(v); });
  };
  n_lists_.assign(pairs_.size(), 0);
  for (const NeighbourList& list : lists_) {
    ++n_lists_[list.pair];
    use(pairs_[list.pair].a, list.a);
    use(pairs_[list.pair].b, list.b);
  }
  for (std::size_t s = 0; s < used_.size(); ++s)
    for (const Index c : used_[s]) marked_[s][c] = 0;
}

void NeighbourLists::make(NeighbourList& list, Scratch& scratch) const {
  const SurfacePair& pair = pairs_[list.pair];
  const ClusterTree &a = broad_phase_.tree(pair.a), &b = broad_phase_.tree(pair.b);
  const double base = base_[list.pair];
  const double wanted =
      std::clamp(steps_to_last * list.change, least_slack * pair.thickness, most_slack_[list.pair]);
  list.slack = std::max(wanted, 1.5 * list.change);
  list.used = 0.0;
  list.cost += ListCosts::made;
  list.near = {};
  list.n_vertex_face = 0;
  list.nearest = std::numeric_limits<double>::infinity();
  if (&a != &b || list.a != list.b) {
    const double gap = gap_between(a.box(list.a), b.box(list.b)) - rounding;
    if (gap > base + list.slack) {
      list.slack = gap - base;
      return;
    }
  }
  const double reach = base + list.slack;
  scratch.near.clear();
  const auto keep = [&](ContactKind kind, Index first, Index second) {
    const PairKey key = pair_key(first, second);
    if (broad_phase_.attached(kind, key)) return;
    const std::array<Index, 4> v = pair_vertices(model_, kind, key);
    FourPoints p;
    for (int k = 0; k < 4; ++k) p[k] = x_.row(v[k]).transpose();
    const double distance = distance_within(kind == ContactKind::VertexFace, p, reach);
    if (!(distance <= reach)) return;
    scratch.near.push_back({key, distance});
    list.n_vertex_face += kind == ContactKind::VertexFace;
    list.nearest = std::min(list.nearest, distance);
  };
  PairSearch(a, b).features(list.a, list.b, reach + rounding, scratch.slots, keep);
  list.near.assign(scratch.near.begin(), scratch.near.end());  // allocates no more than needed
  list.cost += ListCosts::made_pair * static_cast<float>(list.near.size());
}

// Refits the feature boxes at x_ of the clusters of the given lists.
void NeighbourLists::refit_features_of(const Team& team, const std::vector<Index>& which) {
  VertexBoxes& still = broad_phase_.vertex_boxes();
  if (still.use() != use_ || still_at_x_.vertices().empty()) {
    still_at_x_.clear();
    use_ = still.begin();
  }
  std::vector<std::pair<Index, Index>> clusters;  // (surface, cluster)
  const auto mark = [&](Index surface, Index cluster) {
    if (!std::exchange(marked_[surface][cluster], 1)) clusters.emplace_back(surface, cluster);
  };
  for (const Index i : which) {
    mark(pairs_[lists_[i].pair].a, lists_[i].a);
    mark(pairs_[lists_[i].pair].b, lists_[i].b);
  }
  constexpr Index grain = 64;
  const Index n_clusters = static_cast<Index>(clusters.size());
  std::vector<std::vector<Index>> taken((n_clusters + grain - 1) / grain);
  parallel_ranges(team, n_clusters, grain, [&](Index begin, Index end) {
    for (Index c = begin; c < end; ++c)
      refit_.members(clusters[c].first).each(clusters[c].second, [&](Index v) {
        if (still_at_x_.take(v)) taken[begin / grain].push_back(v);
      });
  });
  const std::size_t n_before = still_at_x_.vertices().size();
  for (const std::vector<Index>& of_range : taken) still_at_x_.list(of_range);
  const auto added = std::span(still_at_x_.vertices()).subspan(n_before);
  still.add(added);
  parallel_for(
      team, static_cast<Index>(added.size()),
      [&](Index i) {
        const double* const at = x_.data() + 3 * static_cast<std::size_t>(added[i]);
        still[added[i]] = packed(slabs_of(at, at, 0.0));
      },
      512);
  for (std::size_t s = 0; s < marked_.size(); ++s) {
    ClusterTree& tree = broad_phase_.tree(static_cast<Index>(s));
    tree.refit_features_of(team, marked_[s], still);
    std::fill(marked_[s].begin(), marked_[s].end(), 0);
  }
}

void NeighbourLists::make_ended(const Team& team) {
  std::vector<Index> which, again;
  for (std::size_t i = 0; i < ended_.size(); ++i) {
    if (!ended_[i]) continue;
    which.push_back(static_cast<Index>(i));
    if (lists_[i].slack >= 0.0) again.push_back(static_cast<Index>(i));
  }
  if (which.empty()) return;
  n_made_ += static_cast<std::int64_t>(which.size());
  refit_features_of(team, which);
  constexpr Index at_once = 32;
  const Index n = static_cast<Index>(which.size());
  parallel_tasks(team, (n + at_once - 1) / at_once, [&](Index task) {
    Scratch scratch;
    const Index begin = task * at_once;
    work_on(
        std::min(n - begin, at_once),
        [&](Index i) -> NeighbourList& { return lists_[which[begin + i]]; },
        [&](NeighbourList& list) { make(list, scratch); });
  });
  ended_.assign(lists_.size(), 0);
  for (const Index i : again) {
    Upkeep& upkeep = upkeep_[lists_[i].pair];
    ++upkeep.made_again;
    upkeep.pairs_made_again += static_cast<std::int64_t>(lists_[i].near.size());
  }
}

std::vector<Index> NeighbourLists::unlisted() const {
  std::vector<Index> which;
  for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i)
    if (!listed(i)) which.push_back(i);
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
  return bytes_of(refit_, owners_, base_, most_slack_, inflation_, margin_, x_, before_, from_, to_,
                  covered_) +
         bytes_of(still_at_x_, vertices_, used_, motions_, marked_, lists_, ended_, unlisted_,
                  n_lists_, upkeep_);
}

}  // namespace loomstone
