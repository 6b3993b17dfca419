// Neighbour (Verlet) lists: near pairs of features, kept over several steps in a list for each pair
// of neighbouring clusters. Pairs of clusters stay valid while vertices remain inside boxes around
// their expected motion. The list of a pair stays valid while distances have changed by no more
// than its slack. The relative displacement of the two clusters, each as a ball about its mean,
// bounds that change, so clusters that swing together keep their lists. Lists are always a superset
// of the near pairs: their lifetime affects no result.
#pragma once

#include <limits>
#include <vector>

#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/broad_phase/pair_search.h"
#include "core/collision/narrow_phase/continuous.h"

namespace loomstone {

struct NearPair {
  PairKey key;
  double distance;  // at most the distance at the x of update(), plus `used` of its list [m]
};

// Near pairs of features of two clusters.
struct NeighbourList {
  Index pair;               // of surfaces
  Index a, b;               // clusters of their trees
  Index n_vertex_face = 0;  // of `near`; edges follow
  // When made, the list held all pairs closer than the base distance plus this [m].
  double slack = -1.0;
  double used = 0.0;    // largest change of distances from then to the x of update() [m]
  double change = 0.0;  // and from there to the x1 of cover() [m]
  double nearest = std::numeric_limits<double>::infinity();  // least `distance` [m]
  std::vector<NearPair> near = {};

  ContactKind kind(std::size_t i) const {
    return i < static_cast<std::size_t>(n_vertex_face) ? ContactKind::VertexFace
                                                       : ContactKind::EdgeEdge;
  }
};

class NeighbourLists {
 public:
  // A pair of surfaces is not listed, but searched in full each time, if it has more than
  // `most_per_cluster` pairs of clusters per cluster, or if many clusters move too far for lists to
  // last.
  NeighbourLists(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                 BroadPhase& broad_phase, std::size_t most_per_cluster = 64);

  // Makes the lists contain all pairs closer than the thickness at x.
  void update(const Team& team, const Points& x);
  bool updated_at(const Points& x) const;

  // Makes the lists contain all pairs that come closer than the gap floor while vertices move from
  // the x passed to update() to x1.
  void cover(const Team& team, const Points& x1);

  std::vector<NeighbourList>& lists() { return lists_; }
  bool listed(Index pair) const { return !unlisted_[pair]; }
  // Pairs closer than the thickness at the x of update(), of surface pairs that are not listed.
  std::vector<FeaturePairs> unlisted_near_pairs(const Team& team) const;
  std::vector<Index> unlisted() const;

  std::int64_t n_searches() const { return n_searches_; }  // searches for pairs of clusters
  std::int64_t n_made() const { return n_made_; }          // lists made

 private:
  // Displacements of a cluster's vertices lie in a ball: |displacement - centre| <= radius.
  struct Motion {
    Vec3 centre = Vec3::Zero();  // [m]
    double radius = 0.0;         // [m]
  };

  bool other_trees() const;  // trees have been rebuilt since the clusters were found
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
  // Distance beyond the gap floor that lists still cover when all slack is used [m].
  double spare(Index pair) const { return base_[pair] - 1.01 * largest_gap_floor; }

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  BroadPhase& broad_phase_;
  const std::size_t most_per_cluster_;
  std::vector<double> base_, most_slack_;  // of surface pairs [m]
  std::vector<double> inflation_;          // of surfaces [m]
  Points x_;                               // of the last update
  Points from_, to_;                       // expected motion at the last search for clusters
  std::vector<PackedSlabs> still_,
      moving_;  // boxes of vertices at x, and around the expected motion with its margin
  bool still_at_x_ = false;
  std::vector<int> version_;  // of the trees
  // Vertices of the clusters of a surface; cluster c has vertices [start[c], start[c + 1]).
  struct Members {
    std::vector<Index> start{0}, vertices;
  };
  std::vector<Members> members_;
  std::vector<std::vector<Motion>> motions_;       // of the clusters of each surface
  std::vector<std::vector<std::uint8_t>> marked_;  // scratch: clusters whose boxes are needed
  std::vector<NeighbourList> lists_;               // ascending by surface pair and clusters
  std::vector<std::uint8_t> unlisted_;             // of surface pairs
  std::int64_t n_searches_ = 0, n_made_ = 0;
};

}  // namespace loomstone
