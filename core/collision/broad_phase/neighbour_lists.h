// Neighbour (Verlet) lists of near features, kept over several steps. Each pair of neighbouring
// clusters has a list. The set of cluster pairs stays valid while vertices remain inside boxes
// around their expected motion. A list stays valid while distances have changed by at most its
// slack. The relative displacement of the two clusters bounds this change, so clusters that move
// together keep their list. Lists always contain all near pairs. Their lifetime does not affect
// results. Each list exists on one rank only.
#pragma once

#include <algorithm>
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

namespace loomstone {

struct NearPair {
  PairKey key;
  // The distance at the positions of the last update() is at least this value minus
  // NeighbourList::used [m].
  double distance;
};

// Near pairs of features of two clusters.
struct NeighbourList {
  Index pair;               // index of the surface pair
  Index a, b;               // clusters in the trees of the two surfaces
  Index n_vertex_face = 0;  // number of vertex-face pairs, which come first in `near`
  // A new list contains all pairs closer than NeighbourLists::base_ plus this slack [m].
  double slack = -1.0;
  double used = 0.0;  // bound on the change of distances since the list was made [m]
  // Bound on the change of distances in one step [m]. After update(), it applies to the last step,
  // or to the expected step if cluster pairs have been searched. After cover(), it applies to the
  // motion from the last update() to x1.
  double change = 0.0;
  double nearest = std::numeric_limits<double>::infinity();  // smallest `distance` in `near` [m]
  float cost = 0.0f;     // estimated cost of this list since lists were distributed [ns]
  float seconds = 0.0f;  // measured time of work on this list [s]; see time_work()
  std::vector<NearPair> near = {};

  std::size_t bytes() const { return bytes_of(near); }
  ContactKind kind(std::size_t i) const {
    return i < static_cast<std::size_t>(n_vertex_face) ? ContactKind::VertexFace
                                                       : ContactKind::EdgeEdge;
  }
};

// Approximate costs of work on lists [ns]. Lists are distributed over ranks by these costs. Values
// are fitted to measured times of a drape and of a disc on a table.
struct ListCosts {
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
  // Some surface pairs are unlisted and are searched in full each time. A pair becomes unlisted if
  // it has more than `most_per_cluster` cluster pairs per cluster, or if many of its clusters move
  // too fast for lists to last.
  NeighbourLists(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                 BroadPhase& broad_phase, const Communicator& ranks,
                 std::size_t most_per_cluster = 64);

  // Collective. After update() and make_ended(), the lists contain all pairs of features closer
  // than the thickness at x.
  void update(const Team& team, const Points& x);
  bool updated_at(const Points& x) const;

  // Collective. After cover() and make_ended(), the lists contain all pairs that come closer than
  // CollisionModel::gap_floor while vertices move from the positions of the last update() to x1.
  void cover(const Team& team, const Points& x1);

  // Must follow update() and cover(). Replaces the lists of this rank whose slack is too small by
  // new ones.
  void make_ended(const Team& team);

  std::vector<NeighbourList>& lists() { return lists_; }  // lists of this rank
  // Vertices of all features in the lists of this rank.
  const std::vector<Index>& vertices() const { return vertices_.vertices(); }
  bool listed(Index pair) const { return !unlisted_[pair]; }
  // Returns the feature pairs of unlisted surface pairs that are closer than the thickness at the
  // positions of the last update(). Each pair is found by one rank.
  std::vector<FeaturePairs> unlisted_near_pairs(const Team& team) const;
  std::vector<Index> unlisted() const;
  const Communicator& ranks() const { return ranks_; }

  // Starts to measure the time of work on the lists, for replays on one thread. `clock` is the time
  // that reading the clock takes [s].
  void time_work(double clock) { clock_ = clock; }
  WorkTimer<float> timer(NeighbourList& list) const { return {list.seconds, clock_}; }
  WorkTimer<double> unlisted_timer() const { return {unlisted_seconds_, clock_}; }
  // Return the time of searches without lists and that of passes over all lists since the last call
  // [s].
  double take_unlisted_seconds() { return std::exchange(unlisted_seconds_, 0.0); }
  double take_pass_seconds() { return std::exchange(pass_seconds_, 0.0); }

  std::int64_t n_searches() const { return n_searches_; }  // number of searches for cluster pairs
  std::int64_t n_made() const { return n_made_; }          // number of lists made by this rank
  std::size_t bytes() const;                               // memory [bytes]

 private:
  // Results of the pass of a rank over its lists.
  struct Pass {
    bool unexpected = false;  // vertices have left their expected motion
    bool fast = false;        // some lists have a `change` above the largest slack
    double cost = 0.0;        // cost of all lists since they were distributed [ns]
  };
  // Number of lists of a surface pair on a rank, and number of those with a `change` above the
  // largest slack.
  struct Counts {
    std::int64_t lists = 0, fast = 0;
  };

  void find_motions(const Team& team, const Points& x0, const Points& x1);
  double change_bound(const NeighbourList& list) const;
  bool as_expected(const Team& team, const Points& x, double ahead) const;
  void find_slacks_and_margins(const Points& x);
  void search(const Team& team, const Points& x1);
  void distribute();
  void keep_or_add(const std::vector<std::vector<PairKey>>& found,
                   const std::vector<std::uint8_t>& formed);
  void find_used();
  template <class Ends>
  Pass find_ended(const Team& team, Ends&& ends);
  bool search_is_due(const std::vector<Pass>& passes) const;
  void unlist_fast(const std::vector<Pass>& passes);
  void make(NeighbourList& list, PairSearch::Slots& slots) const;
  // Returns the base distance minus 1.01 times the gap floor [m]. Even a list whose slack is used
  // up contains all pairs closer than the base distance.
  double spare(Index pair) const { return base_[pair] - 1.01 * model_.gap_floor; }

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  BroadPhase& broad_phase_;
  const Communicator& ranks_;
  const std::size_t most_per_cluster_;
  SharedRefit refit_;
  ClusterOwners owners_;
  // Base distance and largest slack of each surface pair [m].
  std::vector<double> base_, most_slack_;
  std::vector<double> inflation_;  // inflation of the vertex boxes of each surface [m]
  // Largest distance of the vertices of each surface from their expected motion [m].
  std::vector<double> margin_;
  Points x_, before_;  // positions of the last update() and of the one before it
  Points from_, to_;   // expected motion in the last search for cluster pairs
  // Box of each vertex at its position in x_, without motion. Only the boxes of the vertices in
  // `still_at_x_` are up to date.
  std::vector<PackedSlabs> still_;
  VertexSet still_at_x_;
  VertexSet vertices_;
  // Clusters of each surface in the lists of this rank, and the motion of each cluster.
  std::vector<std::vector<Index>> used_;
  std::vector<std::vector<ClusterMotion>> motions_;
  std::vector<std::vector<std::uint8_t>> marked_;  // scratch: clusters whose boxes are needed
  std::vector<NeighbourList> lists_;               // sorted by surface pair and clusters
  std::vector<std::uint8_t> ended_;                // (lists) 1: must be made again
  std::vector<std::uint8_t> unlisted_;             // (surface pairs) 1: unlisted
  std::int64_t n_searches_ = 0, n_made_ = 0;
  int updates_ = 0;      // number of updates since lists were distributed
  double clock_ = -1.0;  // see time_work(); negative: work is not timed
  mutable double unlisted_seconds_ = 0.0;
  double pass_seconds_ = 0.0;
};

}  // namespace loomstone
