// The part of NeighbourLists that makes three decisions: which lists must be made again, whether to
// search for cluster pairs, and which surface pairs lose their lists because the lists do not last.
// The ranks agree on the last two decisions.
#include <algorithm>
#include <atomic>
#include <cstring>
#include <utility>

#include "core/collision/broad_phase/neighbour_lists.h"

namespace loomstone {

namespace {

// A search for cluster pairs also distributes the lists over the ranks. To balance the ranks, a
// search is due if the cost of one rank (Pass::cost) exceeds `unbalanced` times the mean cost of
// the ranks and at least `least_updates` updates have followed the last distribution. Our choice.
constexpr double unbalanced = 1.25;
constexpr int least_updates = 8;

// Limits above which searching a surface pair in full is cheaper than keeping its lists. Both are
// averages over `upkeep_updates` updates. `most_made_again` applies to widened lists (see widen()):
// it is the fraction of lists that are made again. `most_pairs_made_again` applies to other lists:
// it is the number of feature pairs in the lists that are made again, divided by the number of
// clusters of the two surfaces. Measured on a ribbon and a dress (widened lists), and on a twisted
// cloth, discs, a drape and a knot.
constexpr double most_made_again = 1.0 / 6.0;
constexpr double most_pairs_made_again = 8.0;
constexpr int upkeep_updates = 8;

}  // namespace

// Returns whether the vertices that this rank checks are within the margin around their expected
// motion, at x and at x + ahead * (x - start). Omits surfaces without lists.
bool NeighbourLists::as_expected(const Team& team, const Points& start, const Points& x,
                                 double ahead) const {
  const IndexRange share = own_vertices();
  std::atomic<bool> all{true};
  std::vector<std::uint8_t> has_lists(model_.surfaces.size(), 0);
  for (std::size_t i = 0; i < pairs_.size(); ++i)
    if (listed(static_cast<Index>(i))) has_lists[pairs_[i].a] = has_lists[pairs_[i].b] = 1;
  for (std::size_t s = 0; s < model_.surfaces.size(); ++s) {
    if (!has_lists[s]) continue;
    const CollisionSurface& surface = model_.surfaces[s];
    const double most = margin_[s] - rounding, most2 = most * most;
    const Index first = std::max(surface.first_vertex, share.begin),
                last = std::min(surface.first_vertex + surface.n_vertices, share.end);
    if (first >= last) continue;
    parallel_ranges(team, last - first, 2048, [&](Index begin, Index end) {
      bool near = true;
      for (Index v = first + begin; v < first + end; ++v) {
        const Index own = v - share.begin;
        const Eigen::RowVector3d along = to_.row(own) - from_.row(own);
        const double length2 = std::max(along.squaredNorm(), 1e-300);
        const auto expected = [&](const Eigen::RowVector3d& offset) {
          const double share_of_motion = std::clamp(offset.dot(along) / length2, 0.0, 1.0);
          return (offset - share_of_motion * along).squaredNorm() <= most2;
        };
        near &= expected(x.row(v) - from_.row(own));
        if (ahead > 0.0)
          near &= expected(x.row(v) + ahead * (x.row(v) - start.row(v)) - from_.row(own));
      }
      if (!near) all = false;
    });
  }
  return all;
}

// Returns whether the vertices that this rank checks have the same positions in x as in covered_.
bool NeighbourLists::covered(const Points& x) const {
  const IndexRange share = own_vertices();
  const auto n = static_cast<std::size_t>(3 * (share.end - share.begin));
  return n == 0 || std::memcmp(x.row(share.begin).data(), covered_.data(), sizeof(double) * n) == 0;
}

void NeighbourLists::update(const Team& team, const Points& x) {
  begin_update(team, x);
  if (unchecked_) end_update(team, results_of_ranks(ranks_, [&] { return pass_at_x(team); }));
}

void NeighbourLists::begin_update(const Team& team, const Points& x) {
  const bool first = x_.rows() != x.rows(), again = first || refit_.other_trees();
  if (again) lists_.clear(), ended_.clear();
  if (first) x_ = x, find_slacks_and_margins(x);
  before_.swap(x_);
  x_ = x;
  still_at_x_.clear();
  ++n_updates_;
  ++updates_;
  count_update();
  unchecked_ = !again;
  if (again) {
    search_at_x(team, true);
  } else if (!settled_) {
    end_update(team, results_of_ranks(ranks_, [&] { return pass_at_x(team); }));
  }
}

// Goes through the lists of this rank after begin_update(). Adds to `used` of each list the bound
// on the change of distances since the preceding update, and finds the lists that must be made
// again. Also checks the motion of vertices, unless an unlisted surface pair gets lists again (then
// a search is due anyway) or cover() has checked the same positions. Does nothing if begin_update()
// has completed the update.
NeighbourLists::Pass NeighbourLists::pass_at_x(const Team& team) {
  if (!unchecked_) return {};
  const WorkTimer<double> timing(pass_seconds_, clock_);
  Pass pass;
  pass.unexpected = retries_within(1);
  if (!pass.unexpected && !(settled_ && covered(x_)))
    pass.unexpected = !as_expected(team, before_, x_, 1.0);
  find_motions(team, before_, x_);
  parallel_for(team, static_cast<Index>(lists_.size()), [&](Index i) {
    lists_[i].change = change_bound(lists_[i]);
    lists_[i].used += lists_[i].change;
  });
  find_ended(team, pass, [&](const NeighbourList& list) { return ends_at_x(list); });
  return pass;
}

bool NeighbourLists::end_update(const Team& team, const std::vector<Pass>& passes) {
  if (!std::exchange(unchecked_, false)) return true;
  const bool search = settled_ ? any(passes, &Pass::unexpected) : search_is_due(passes);
  settled_ = false;
  if (search)
    search_at_x(team, false);
  else
    unlist_fast(passes);
  return !search;
}

// Counts an update: adds it to the upkeep of listed surface pairs, and shortens the pause of
// unlisted ones.
void NeighbourLists::count_update() {
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (unlisted_[i] > 1) --unlisted_[i];
    if (unlisted_[i] > 0) continue;
    Upkeep& upkeep = upkeep_[i];
    if (upkeep.updates == upkeep_updates) upkeep = {};
    ++upkeep.updates;
    upkeep.lists += n_lists_[i];
  }
}

// Returns whether any unlisted surface pair gets lists again within the given number of updates,
// including the present one.
bool NeighbourLists::retries_within(int updates) const {
  return std::any_of(unlisted_.begin(), unlisted_.end(),
                     [&](int left) { return left > 0 && left <= updates; });
}

// Returns whether too many lists of a surface pair were made again in `upkeep_updates` updates.
// `upkeep` is the upkeep on `n_ranks` ranks. Always returns false before the last of these updates.
bool NeighbourLists::costly(std::size_t pair, const Upkeep& upkeep, int n_ranks) const {
  if (upkeep.updates != upkeep_updates) return false;
  if (extra_ > 0.0)
    return static_cast<double>(upkeep.made_again) >
           most_made_again * static_cast<double>(upkeep.lists);
  const std::size_t n_clusters = motions_[pairs_[pair].a].size() + motions_[pairs_[pair].b].size();
  const double share = static_cast<double>(n_ranks) / ranks_.size();
  return static_cast<double>(upkeep.pairs_made_again) >
         share * most_pairs_made_again * upkeep_updates * static_cast<double>(n_clusters);
}

// Searches for cluster pairs, in the expectation that vertices repeat their last step from the
// positions of the last update. Then marks the lists that must be made and calls unlist_fast().
// Surface pairs whose pause is over get lists again. `all` is true if there are no lists before the
// search.
void NeighbourLists::search_at_x(const Team& team, bool all) {
  const std::vector<int> before = unlisted_;
  const bool retries = retries_within(1);
  std::replace(unlisted_.begin(), unlisted_.end(), 1, 0);
  const Points ahead = 2.0 * x_ - before_;  // extrapolates the last step
  search(team, ahead, retries);
  for (std::size_t i = 0; i < pairs_.size(); ++i)
    if (listed(static_cast<Index>(i)) && (all || before[i] > 0)) upkeep_[i] = {};
  unlist_fast(results_of_ranks(ranks_, [&] {
    find_motions(team, x_, ahead);
    parallel_for(team, static_cast<Index>(lists_.size()),
                 [&](Index i) { lists_[i].change = change_bound(lists_[i]); });
    Pass pass;
    find_ended(team, pass, [&](const NeighbourList& list) { return ends_at_x(list); });
    return pass;
  }));
}

// Returns whether a list must be made again after an update: its slack is used up, or slack and
// spare() would not cover another change of distances by list.change. The negated comparisons are
// also true for NaN.
bool NeighbourLists::ends_at_x(const NeighbourList& list) const {
  return !(list.used <= list.slack) ||
         !(list.used + list.change <= list.slack + spare(list.pair, Cover::Gap));
}

void NeighbourLists::cover(const Team& team, const Points& x1, Cover what) {
  begin_cover(team, x1, what);
  end_cover(team, x1, results_of_ranks(ranks_, [&] { return pass_to(team, x1); }));
}

void NeighbourLists::begin_cover(const Team& team, const Points& x1, Cover what) {
  uncovered_ = true;
  cover_ = what;
  if (!refit_.other_trees()) return;
  lists_.clear(), ended_.clear();
  search(team, x1);
}

NeighbourLists::Pass NeighbourLists::pass_to(const Team& team, const Points& x1) {
  if (!uncovered_) return {};
  // Makes the lists that the last update has marked, because find_ended_before() replaces the
  // marks. For Cover::Reach, this is not necessary: every list that find_ended_before() leaves
  // unmarked contains all pairs that an update requires.
  if (cover_ == Cover::Gap) make_ended(team);
  Pass pass = find_ended_before(team, x1);
  pass.unexpected = unlisted().size() < pairs_.size() && !as_expected(team, x_, x1, 0.0);
  if (ranks_.size() == 1 || cover_ == Cover::Reach) return pass;
  pass.due = pass.unexpected || retries_within(2) || !as_expected(team, x_, x1, 1.0);
  covered_ = own_rows(x1);
  return pass;
}

// Finds the lists of this rank that may lack pairs required by `cover_` for the motion from x_ to
// x1.
NeighbourLists::Pass NeighbourLists::find_ended_before(const Team& team, const Points& x1) {
  const WorkTimer<double> timing(pass_seconds_, clock_);
  find_motions(team, x_, x1);
  parallel_for(team, static_cast<Index>(lists_.size()),
               [&](Index i) { lists_[i].change = change_bound(lists_[i]); });
  Pass pass;
  find_ended(team, pass, [&](const NeighbourList& list) {
    return !(list.slack >= 0.0) ||
           !(list.used + list.change <= list.slack + spare(list.pair, cover_));
  });
  return pass;
}

bool NeighbourLists::end_cover(const Team& team, const Points& x1,
                               const std::vector<Pass>& passes) {
  if (!std::exchange(uncovered_, false)) return true;
  if (any(passes, &Pass::unexpected)) {
    search(team, x1);
    unlist_fast(results_of_ranks(ranks_, [&] { return find_ended_before(team, x1); }));
    return false;
  }
  settled_ = cover_ == Cover::Gap && ranks_.size() > 1 && !any(passes, &Pass::due) &&
             !search_is_due(passes);
  unlist_fast(passes);
  return true;
}

bool NeighbourLists::any(const std::vector<Pass>& passes, bool Pass::* flag) {
  return std::any_of(passes.begin(), passes.end(), [&](const Pass& pass) { return pass.*flag; });
}

// Returns whether a search is due: an unlisted surface pair gets lists again, vertices have left
// their expected motion on some rank, the costs of the ranks are unbalanced, or a test makes the
// owners rotate.
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

// Marks the lists of this rank for which `ends` is true, and updates `fast` and `cost` of `pass`.
template <class Ends>
void NeighbourLists::find_ended(const Team& team, Pass& pass, Ends&& ends) {
  constexpr Index grain = 1024;
  const Index n = static_cast<Index>(lists_.size());
  ended_.assign(n, 0);
  std::vector<Pass> of_range((n + grain - 1) / grain);
  parallel_ranges(team, n, grain, [&](Index begin, Index end) {
    Pass& own = of_range[begin / grain];
    for (Index i = begin; i < end; ++i) {
      NeighbourList& list = lists_[i];
      list.spent += ListCosts::pass;
      own.fast |= list.change > most_slack_[list.pair];
      own.cost += list.spent;
      ended_[i] = ends(list);
    }
  });
  for (const Pass& own : of_range) pass.fast |= own.fast, pass.cost += own.cost;
  for (std::size_t i = 0; i < pairs_.size(); ++i)
    pass.fast |= listed(static_cast<Index>(i)) && costly(i, upkeep_[i], 1);
}

// Makes a surface pair unlisted if more than a quarter of its lists on all ranks have a `change`
// above most_slack_, or if too many of its lists were made again; see costly().
void NeighbourLists::unlist_fast(const std::vector<Pass>& passes) {
  if (std::none_of(passes.begin(), passes.end(), [](const Pass& pass) { return pass.fast; }))
    return;
  const Gathered<Counts> counts = gather_from_ranks(ranks_, [&] {
    std::vector<Counts> own(pairs_.size());
    for (std::size_t i = 0; i < pairs_.size(); ++i) own[i].upkeep = upkeep_[i];
    for (const NeighbourList& list : lists_) {
      ++own[list.pair].lists;
      own[list.pair].fast += list.change > most_slack_[list.pair];
    }
    return own;
  });
  bool any = false;
  for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
    Counts sum;
    sum.upkeep.updates = upkeep_[pair].updates;
    for (std::size_t k = pair; k < counts.elements.size(); k += pairs_.size()) {
      const Counts& own = counts.elements[k];
      sum.lists += own.lists, sum.fast += own.fast;
      sum.upkeep.lists += own.upkeep.lists;
      sum.upkeep.made_again += own.upkeep.made_again;
      sum.upkeep.pairs_made_again += own.upkeep.pairs_made_again;
    }
    if (!listed(static_cast<Index>(pair))) continue;
    const bool too_costly = costly(pair, sum.upkeep, ranks_.size());
    if (sum.fast > sum.lists / 4 || too_costly) unlist(pair, too_costly), any = true;
  }
  if (!any) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < lists_.size(); ++i) {
    if (!listed(lists_[i].pair)) continue;
    ended_[kept] = ended_[i];
    if (kept != i) lists_[kept] = std::move(lists_[i]);
    ++kept;
  }
  lists_.erase(lists_.begin() + static_cast<std::ptrdiff_t>(kept), lists_.end());
  ended_.resize(kept);
  find_used();
}

}  // namespace loomstone
