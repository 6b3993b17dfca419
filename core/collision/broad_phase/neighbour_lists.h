// Neighbour (Verlet) lists of near features, kept over several steps. Each pair of neighbouring
// clusters has a list. Pairs of clusters stay valid while vertices remain inside boxes around their
// expected motion. A list stays valid while distances have changed by at most its slack. The
// relative displacement of the two clusters bounds this change, so clusters that move together keep
// their list. Lists always contain all near pairs. Their lifetime does not affect results.
#pragma once

#include <limits>
#include <vector>

#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/broad_phase/pair_search.h"
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
  // A new list contains all pairs closer than the base distance plus this slack [m].
  double slack = -1.0;
  double used = 0.0;  // bound on the change of distances since the list was made [m]
  // Bound on the change of distances in one step [m]. After update(), it is that of the last or the
  // expected step. After cover(), it is that of the step from the last update() to x1.
  double change = 0.0;
  double nearest = std::numeric_limits<double>::infinity();  // smallest `distance` [m]
  std::vector<NearPair> near = {};

  ContactKind kind(std::size_t i) const {
    return i < static_cast<std::size_t>(n_vertex_face) ? ContactKind::VertexFace
                                                       : ContactKind::EdgeEdge;
  }
};

class NeighbourLists {
 public:
  // Some surface pairs are unlisted and are searched in full each time. A pair becomes unlisted if
  // it has more than `most_per_cluster` cluster pairs per cluster, or if many of its clusters move
  // too fast for lists to last.
  NeighbourLists(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                 BroadPhase& broad_phase, std::size_t most_per_cluster = 64);

  // Updates the lists so that they contain all pairs of features closer than the thickness at x.
  void update(const Team& team, const Points& x);
  bool updated_at(const Points& x) const;

  // Extends the lists so that they contain all pairs that come closer than
  // CollisionModel::gap_floor while vertices move from the positions of the last update() to x1.
  void cover(const Team& team, const Points& x1);

  std::vector<NeighbourList>& lists() { return lists_; }
  bool listed(Index pair) const { return !unlisted_[pair]; }
  // Returns the feature pairs of unlisted surface pairs that are closer than the thickness at the
  // positions of the last update().
  std::vector<FeaturePairs> unlisted_near_pairs(const Team& team) const;
  std::vector<Index> unlisted() const;

  std::int64_t n_searches() const { return n_searches_; }  // number of searches for cluster pairs
  std::int64_t n_made() const { return n_made_; }          // number of lists made

 private:
  // Ball |d - centre| <= radius that contains the displacements d of all vertices of a cluster.
  struct Motion {
    Vec3 centre = Vec3::Zero();  // [m]
    double radius = 0.0;         // [m]
  };

  // Returns whether trees were rebuilt since the last search for cluster pairs.
  bool other_trees() const;
  void find_members(Index surface);
  void find_motions(const Team& team, const Points& x0, const Points& x1);
  double change_bound(const NeighbourList& list) const;
  bool as_expected(const Team& team, const Points& x) const;
  double margin_of(Index surface) const;
  void pack_still(const Team& team);
  void search(const Team& team, const Points& x1);
  template <class Ends>
  std::vector<Index> ended(const Team& team, Ends&& ends);
  void make(const Team& team, const std::vector<Index>& which);
  void make(NeighbourList& list, PairSearch::Slots& slots) const;
  // Returns the base distance minus the gap floor [m]. Even a list whose slack is used up contains
  // all pairs closer than the base distance.
  double spare(Index pair) const { return base_[pair] - 1.01 * model_.gap_floor; }

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  BroadPhase& broad_phase_;
  const std::size_t most_per_cluster_;
  // Base distance and largest slack of each surface pair [m].
  std::vector<double> base_, most_slack_;
  std::vector<double> inflation_;  // inflation of the vertex boxes of each surface [m]
  Points x_;                       // positions of the last update()
  Points from_, to_;               // expected motion in the last search for cluster pairs
  // Vertex boxes at x_, and vertex boxes around the expected motion including its margin.
  std::vector<PackedSlabs> still_, moving_;
  bool still_at_x_ = false;
  std::vector<int> version_;  // versions of the trees at the last search
  // Vertices of the clusters of a surface. Cluster c has entries start[c] to start[c + 1] - 1.
  struct Members {
    std::vector<Index> start{0}, vertices;
  };
  std::vector<Members> members_;
  std::vector<std::vector<Motion>> motions_;       // motion of each cluster of each surface
  std::vector<std::vector<std::uint8_t>> marked_;  // scratch: clusters whose boxes are needed
  std::vector<NeighbourList> lists_;               // sorted by surface pair and clusters
  std::vector<std::uint8_t> unlisted_;             // (surface pairs) 1: unlisted
  std::int64_t n_searches_ = 0, n_made_ = 0;
};

}  // namespace loomstone
