// Neighbour (Verlet) lists of pairs of nearby features, kept over several steps. Each pair of
// neighbouring clusters has a list, unless its surface pair is unlisted: such surface pairs are
// searched without lists. The set of cluster pairs stays valid while vertices remain within a
// margin around their expected motion. A list stays valid as long as distances have changed by at
// most its slack. The relative displacement of the two clusters bounds this change, so clusters
// that move together keep their list. A valid list contains all near feature pairs of its two
// clusters, except those that the broad phase excludes, so the lifetime of lists does not affect
// results. Each list exists on one rank only.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/broad_phase/cluster_owners.h"
#include "core/collision/broad_phase/pair_search.h"
#include "core/collision/broad_phase/shared_refit.h"
#include "core/collision/narrow_phase/continuous.h"
#include "core/parallel/repeated_gather.h"

namespace loomstone {

struct NearPair {
  PairKey key;
  // The distance of the pair at the positions of the last update() is at least this value minus
  // NeighbourList::used [m].
  double distance;
};

// Near pairs of features of two clusters.
struct NeighbourList {
  Index pair;               // index of the surface pair
  Index a, b;               // clusters in the trees of the two surfaces
  Index n_vertex_face = 0;  // number of vertex-face pairs, which come first in `near`
  // A list contains all pairs that were closer than NeighbourLists::base_ plus this slack [m] when
  // the list was made. -1: the list has not been made.
  double slack = -1.0;
  double used = 0.0;  // bound on the change of distances since the list was made [m]
  // Bound on the change of distances in one step [m]. After update(), it applies to the last step,
  // or to the extrapolated next step if update() has searched for cluster pairs. After cover(), it
  // applies to the motion from the last update() to x1.
  double change = 0.0;
  double nearest = std::numeric_limits<double>::infinity();  // smallest `distance` in `near` [m]
  float cost = 0.0f;  // estimated cost of work on this list since lists were distributed [ns]
  // Estimate of the time spent since lists were distributed [ns]; ranks balance these times.
  float spent = 0.0f;
  float seconds = 0.0f;  // measured time of work on this list [s]; see time_work()
  std::vector<NearPair> near = {};

  std::size_t bytes() const { return bytes_of(near); }
  ContactKind kind(std::size_t i) const {
    return i < static_cast<std::size_t>(n_vertex_face) ? ContactKind::VertexFace
                                                       : ContactKind::EdgeEdge;
  }
};

// Approximate costs of work on lists [ns], fitted to measured times. NeighbourLists::work_on()
// divides measured times among lists in proportion to these costs. Only passes are not measured in
// a run: each adds `pass` to the time spent on a list.
struct ListCosts {
  static constexpr float pass = 15.0f;        // examining a list in a pass over all lists
  static constexpr float list = 60.0f;        // visiting a list
  static constexpr float pair = 3.0f;         // reading a pair of a list
  static constexpr float distance = 60.0f;    // computing the distance of a pair
  static constexpr float contact = 150.0f;    // making a contact
  static constexpr float impact = 250.0f;     // testing a pair for an impact
  static constexpr float made = 300.0f;       // making a list, without its pairs
  static constexpr float made_pair = 120.0f;  // adding a pair to a new list
};

// Adds the time between its construction and destruction to `seconds`, minus the time that reading
// the clock takes (`clock`) [s]. Does nothing if `clock` is negative.
template <class Number>
class WorkTimer {
 public:
  WorkTimer(Number& seconds, double clock) : seconds_(seconds), clock_(clock) {
    if (clock_ >= 0.0) start_ = std::chrono::steady_clock::now();
  }
  ~WorkTimer() {
    if (clock_ < 0.0) return;
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    seconds_ += static_cast<Number>(std::max(0.0, passed.count() - clock_));
  }
  WorkTimer(const WorkTimer&) = delete;
  WorkTimer& operator=(const WorkTimer&) = delete;

 private:
  Number& seconds_;
  const double clock_;
  std::chrono::steady_clock::time_point start_;
};

class NeighbourLists {
 public:
  // Some surface pairs are unlisted and are searched in full each time. A surface pair becomes
  // unlisted if it has more than `most_per_cluster` times as many cluster pairs as its two surfaces
  // have clusters, if distances change so fast that many of its lists would not last, or if too
  // many of its lists are made again. The surface pair gets lists again in the next update or, if
  // lists are widened or too many were made again, after a pause.
  NeighbourLists(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                 BroadPhase& broad_phase, const Communicator& ranks,
                 std::size_t most_per_cluster = 64);

  // Result of the pass of a rank over its lists.
  struct Pass {
    // Vertices left their expected motion, or an unlisted surface pair gets lists again.
    bool unexpected = false;
    // An update at x1, the end of the motion of cover(), needs a search. Set only for Cover::Gap on
    // several ranks.
    bool due = false;
    bool fast = false;  // a surface pair may have to be unlisted
    double cost = 0.0;  // sum of NeighbourList::spent over the lists of the rank [ns]
  };

  // Widens all lists, so that their base distance (base_) exceeds the thickness by at least `extra`
  // [m]. All ranks must pass the same value. Affects Cover::Reach, and otherwise only speed. The
  // next update() then makes all lists again. Does nothing if the lists are already this wide.
  void widen(double extra);

  // Collective. After update() and make_ended(), the lists of all ranks together contain all pairs
  // of features whose distance at positions x is less than the thickness, except those of unlisted
  // surface pairs and those that BroadPhase excludes.
  void update(const Team& team, const Points& x);
  bool updated_at(const Points& x) const;
  std::int64_t n_updates() const { return n_updates_; }  // number of updates so far

  // Selects the feature pairs that the lists of all ranks together must contain after cover() and
  // make_ended(). Only features of listed surface pairs count, and pairs that BroadPhase excludes
  // are left out. Vertices move from the positions of the last update() to `x1`, the argument of
  // cover().
  // Gap: all pairs that come closer than CollisionModel::gap_floor.
  // Reach: all pairs that meet two conditions. The 18-DOPs of the motions of both features overlap
  // if inflated by half the thickness plus half the extra distance of widen(). The distance between
  // the features at the start is at most the sum of the thickness, the extra distance and the
  // largest relative displacement of their vertices.
  enum class Cover { Gap, Reach };

  // Collective. After cover() and make_ended(), the lists are valid for the motion to x1; see
  // Cover.
  void cover(const Team& team, const Points& x1, Cover what = Cover::Gap);

  // The next six functions are the parts of update() and cover(). With them, ranks can test pairs
  // before they know that the lists are complete, and send results and passes in one gather. For an
  // update, all ranks first call begin_update(). Each rank then calls pass_at_x(). If the returned
  // pass is not `unexpected`, the rank also calls make_ended() and tests the pairs in its lists.
  // Finally, each rank gives the passes of all ranks to end_update(). If end_update() returns
  // false, it has searched for cluster pairs again. All ranks then repeat everything after
  // begin_update(). The parts of cover() are used in the same way.
  void begin_update(const Team& team, const Points& x);
  Pass pass_at_x(const Team& team);
  bool end_update(const Team& team, const std::vector<Pass>& passes);
  void begin_cover(const Team& team, const Points& x1, Cover what = Cover::Gap);
  Pass pass_to(const Team& team, const Points& x1);
  bool end_cover(const Team& team, const Points& x1, const std::vector<Pass>& passes);
  GatherRoom& contact_room() { return contact_room_; }

  // Makes the lists of this rank that are new or have too little slack left. Must follow update(),
  // cover(), pass_at_x() or pass_to().
  void make_ended(const Team& team);

  std::vector<NeighbourList>& lists() { return lists_; }  // lists of this rank
  // Vertices of all clusters in the lists of this rank.
  const std::vector<Index>& vertices() const { return vertices_.vertices(); }
  // Calls work(list, range) for all lists of this rank, in parallel. `range` is the index of the
  // range that contains the list. There are n_ranges() ranges of at most `most_at_once` lists.
  template <class Work>
  void each_list(const Team& team, Work&& work) {
    const Index n = static_cast<Index>(lists_.size());
    parallel_tasks(team, static_cast<Index>(n_ranges()), [&](Index range) {
      const Index begin = range * most_at_once;
      work_on(
          std::min(n - begin, most_at_once),
          [&](Index i) -> NeighbourList& { return lists_[begin + i]; },
          [&](NeighbourList& list) { work(list, range); });
    });
  }
  std::size_t n_ranges() const { return (lists_.size() + most_at_once - 1) / most_at_once; }
  bool listed(Index pair) const { return unlisted_[pair] == 0; }
  // Returns one entry for each surface pair. The entry of an unlisted surface pair contains the
  // feature pairs that this rank finds to be at most the thickness apart, up to rounding, at the
  // positions of the last update(). Each feature pair is found by one rank. Pairs that BroadPhase
  // excludes are omitted. The entry of a listed surface pair is empty.
  std::vector<FeaturePairs> unlisted_near_pairs(const Team& team) const;
  std::vector<Index> unlisted() const;
  const Communicator& ranks() const { return ranks_; }

  // Starts to measure NeighbourList::seconds and the times that take_unlisted_seconds() and
  // take_pass_seconds() return, for CollisionReplay. `clock` is the time that reading the clock
  // takes [s].
  void time_work(double clock) { clock_ = clock; }
  WorkTimer<double> unlisted_timer() const { return {unlisted_seconds_, clock_}; }
  // Return the time that this rank has spent in searches of unlisted surface pairs and in passes
  // over its lists, respectively, since the last call of the same function [s]. It is 0 unless
  // time_work() has been called.
  double take_unlisted_seconds() { return std::exchange(unlisted_seconds_, 0.0); }
  double take_pass_seconds() { return std::exchange(pass_seconds_, 0.0); }

  std::int64_t n_searches() const { return n_searches_; }  // number of searches for cluster pairs
  std::int64_t n_made() const { return n_made_; }          // number of lists made by this rank
  std::size_t bytes() const;                               // memory [bytes]

 private:
  // Upkeep of the lists of a surface pair on this rank over several updates. Lists that this rank
  // makes for the first time do not count as made again: they are new, their clusters have been
  // formed again, or they come from another rank.
  struct Upkeep {
    int updates = 0;
    std::int64_t lists = 0;             // number of lists, summed over the updates
    std::int64_t made_again = 0;        // number of lists that were made again
    std::int64_t pairs_made_again = 0;  // number of feature pairs in these lists
  };
  // Counts for the lists of a surface pair on a rank. `lists` is the number of lists, and `fast`
  // the number of lists whose `change` exceeds most_slack_.
  struct Counts {
    std::int64_t lists = 0, fast = 0;
    Upkeep upkeep;
  };

  // unlist() sets unlisted_ to this value if lists are widened or costly().
  static constexpr int pause = 64;
  static constexpr Index most_at_once = 64;  // largest number of lists in a call of work_on()
  // Calls work(list) for the n lists list_at(i). Divides the time that all calls take among the
  // lists in proportion to the estimated costs of their work.
  template <class ListAt, class Work>
  void work_on(Index n, ListAt&& list_at, Work&& work) const {
    using Clock = std::chrono::steady_clock;
    // Bounds on the ratio of time to estimated cost. Ratios beyond them are attributed to an
    // interruption of the thread or to a coarse clock.
    constexpr float least_ratio = 0.25f, most_ratio = 4.0f;
    std::array<float, most_at_once> costs;
    float sum = 0.0f;
    const auto start = Clock::now();
    for (Index i = 0; i < n; ++i) {
      NeighbourList& list = list_at(i);
      const float before = list.cost;
      const WorkTimer<float> timing(list.seconds, clock_);
      work(list);
      costs[i] = list.cost - before;
      sum += costs[i];
    }
    const std::chrono::duration<float, std::nano> passed = Clock::now() - start;
    const float ratio = std::clamp(passed.count() / std::max(sum, 1.0f), least_ratio, most_ratio);
    for (Index i = 0; i < n; ++i) list_at(i).spent += ratio * costs[i];
  }
  void find_motions(const Team& team, const Points& x0, const Points& x1);
  double change_bound(const NeighbourList& list) const;
  // Vertices whose motion this rank checks.
  IndexRange own_vertices() const {
    return even_share(model_.n_vertices, ranks_.rank(), ranks_.size());
  }
  // Returns the rows of x that belong to own_vertices().
  auto own_rows(const Points& x) const {
    const IndexRange own = own_vertices();
    return x.middleRows(own.begin, own.end - own.begin);
  }
  bool as_expected(const Team& team, const Points& start, const Points& x, double ahead) const;
  bool covered(const Points& x) const;
  void find_bases();
  Pass find_ended_before(const Team& team, const Points& x1);
  void search_at_x(const Team& team, bool all);
  void count_update();
  bool retries_within(int updates) const;
  bool costly(std::size_t pair, const Upkeep& upkeep, int n_ranks) const;
  // Leaves a surface pair without lists until the next update, or for a pause if lists are widened
  // or costly().
  void unlist(std::size_t pair, bool costly = false) {
    unlisted_[pair] = costly || extra_ > 0.0 ? pause : 1;
  }
  bool ends_at_x(const NeighbourList& list) const;
  void find_slacks_and_margins(const Points& x);
  void search(const Team& team, const Points& x1, bool may_rebuild = false);
  void distribute();
  void keep_or_add(const std::vector<std::vector<PairKey>>& found,
                   const std::vector<std::uint8_t>& formed);
  void find_used();
  void refit_features_of(const Team& team, const std::vector<Index>& which);
  template <class Ends>
  void find_ended(const Team& team, Pass& pass, Ends&& ends);
  static bool any(const std::vector<Pass>& passes, bool Pass::* flag);
  bool search_is_due(const std::vector<Pass>& passes) const;
  void unlist_fast(const std::vector<Pass>& passes);
  // Scratch memory of make().
  struct Scratch {
    PairSearch::Slots slots;
    std::vector<NearPair> near;
  };
  void make(NeighbourList& list, Scratch& scratch) const;
  // Returns how much distances may change in addition to the slack of a list before the list may
  // lack a pair that `what` requires [m].
  double spare(Index pair, Cover what) const {
    return base_[pair] -
           (what == Cover::Reach ? pairs_[pair].thickness + extra_ : 1.01 * model_.gap_floor);
  }

  // Allowance for rounding errors [m]. It is added to inflations, to search distances and to each
  // bound on a change of distances, and subtracted from gaps and margins.
  static constexpr double rounding = 1e-12;

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  BroadPhase& broad_phase_;
  const Communicator& ranks_;
  const std::size_t most_per_cluster_;
  SharedRefit refit_;
  ClusterOwners owners_;
  double extra_ = 0.0;  // see widen() [m]
  // Base distance of each surface pair, and upper bound on the slack of its lists [m]. make()
  // exceeds this bound if 1.5 steps need more slack or the boxes of the two clusters are far apart.
  std::vector<double> base_, most_slack_;
  // Inflation of the vertex boxes of each surface in searches, without margin_ [m].
  std::vector<double> inflation_;
  // (surfaces) Largest distance by which vertices may deviate from their expected motion before a
  // search for cluster pairs is due [m].
  std::vector<double> margin_;
  // Positions of the last update() and of the update() before it. x_ has 0 rows after widen().
  Points x_, before_;
  // Rows of own_vertices(). from_, to_: start and end of the motion that the last search for
  // cluster pairs expected. covered_: end of the motion for which Pass::due was last determined.
  Points from_, to_, covered_;
  bool settled_ = false;      // the ranks agree that an update at covered_ needs no search
  bool unchecked_ = false;    // the update of the last begin_update() still needs end_update()
  bool uncovered_ = false;    // the last begin_cover() still needs end_cover()
  Cover cover_ = Cover::Gap;  // argument of the last begin_cover()
  GatherRoom contact_room_;
  // Vertices whose boxes in BroadPhase::vertex_boxes() enclose only their positions in x_. This
  // holds as long as VertexBoxes::use() equals use_; otherwise these boxes have been removed.
  VertexSet still_at_x_;
  std::int64_t use_ = 0;
  VertexSet vertices_;
  // used_[s]: clusters of surface s in the lists of this rank. motions_[s][c]: motion of such a
  // cluster c.
  std::vector<std::vector<Index>> used_;
  std::vector<std::vector<ClusterMotion>> motions_;
  std::vector<std::vector<std::uint8_t>> marked_;  // (surfaces x clusters) scratch
  std::vector<NeighbourList> lists_;               // sorted by surface pair and clusters
  std::vector<std::uint8_t> ended_;                // (lists) 1: must be made
  // (surface pairs) 0: listed. Otherwise, each update decrements the value if it is above 1. If the
  // value is then 1, the surface pair gets lists again.
  std::vector<int> unlisted_;
  std::vector<std::int64_t> n_lists_;  // (surface pairs) number of lists of this rank
  std::vector<Upkeep> upkeep_;         // (surface pairs)
  std::int64_t n_updates_ = 0, n_searches_ = 0, n_made_ = 0;
  int updates_ = 0;      // number of updates since lists were distributed
  double clock_ = -1.0;  // argument of time_work() [s]; negative: not called yet
  mutable double unlisted_seconds_ = 0.0;
  double pass_seconds_ = 0.0;
};

}  // namespace loomstone
