// Pairs of features that are near, kept over several steps in lists of two clusters each. Two
// things are kept: which clusters come near each other, as long as vertices stay inside boxes that
// hold the motion that is expected of them; and which of their features do, as long as distances
// have changed by no more than the slack that a list was made with. How far distances change is
// bounded by the displacements of the two clusters, each about its mean: neighbours that swing
// together change little. Lists are a superset either way: how long they live changes no result.
#pragma once

#include <limits>
#include <vector>

#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/broad_phase/pair_search.h"
#include "core/collision/narrow_phase/continuous.h"

namespace loomstone {

struct NearPair {
  PairKey key;
  double distance;  // no more than it is at the x of update(), plus `used` of its list [m]
};

// Pairs of features of two clusters.
struct NearList {
  Index pair;               // of surfaces
  Index a, b;               // clusters of their trees
  Index n_vertex_face = 0;  // of `near`; edges follow
  double slack =
      -1.0;           // holds what was closer than the base distance and this when it was made [m]
  double used = 0.0;  // by how much distances may have changed since, at the x of update() [m]
  double change = 0.0;  // and from there to the x1 of cover() [m]
  double nearest = std::numeric_limits<double>::infinity();  // of all [m]
  std::vector<NearPair> near = {};

  ContactKind kind(std::size_t i) const {
    return i < static_cast<std::size_t>(n_vertex_face) ? ContactKind::VertexFace
                                                       : ContactKind::EdgeEdge;
  }
};

class NearLists {
 public:
  // A pair of surfaces with more pairs of clusters than `most_per_cluster` each, or of which many
  // clusters move too far for lists to last, is not listed but searched anew each time.
  NearLists(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
            BroadPhase& broad_phase, std::size_t most_per_cluster = 64);

  // Makes the lists hold all pairs closer than the thickness at x.
  void update(const Team& team, const Points& x);
  bool updated_at(const Points& x) const;

  // Makes the lists hold all pairs that come closer than the floor under gaps while x -> x1, x
  // being that of update().
  void cover(const Team& team, const Points& x1);

  std::vector<NearList>& lists() { return lists_; }
  bool listed(Index pair) const { return !unlisted_[pair]; }
  // Pairs closer than the thickness at the x of update(), of surface pairs that are not listed.
  std::vector<FeaturePairs> unlisted_near_pairs(const Team& team) const;
  std::vector<Index> unlisted() const;

  std::int64_t n_searches() const { return n_searches_; }  // of clusters
  std::int64_t n_made() const { return n_made_; }          // lists

 private:
  // Displacements of a cluster's vertices lie in a ball: |displacement - centre| <= radius.
  struct Motion {
    Vec3 centre = Vec3::Zero();  // [m]
    double radius = 0.0;         // [m]
  };

  bool other_trees() const;  // than those that clusters were found in
  void find_members(Index surface);
  void find_motions(const Team& team, const Points& x0, const Points& x1);
  double change_bound(const NearList& list) const;
  bool as_expected(const Team& team, const Points& x) const;
  double margin_of(Index surface) const;
  void pack_still(const Team& team);
  void search(const Team& team, const Points& x1);
  template <class Ends>
  std::vector<Index> ended(const Team& team, Ends&& ends);
  void make(const Team& team, const std::vector<Index>& which);
  void make(NearList& list, PairSearch::Slots& slots) const;
  // What is held beyond the floor under gaps when all slack is used [m].
  double spare(Index pair) const { return base_[pair] - 1.01 * largest_gap_floor; }

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  BroadPhase& broad_phase_;
  const std::size_t most_per_cluster_;
  std::vector<double> base_, most_slack_;  // of surface pairs [m]
  std::vector<double> inflation_;          // of surfaces [m]
  Points x_;                               // of the last update
  Points from_, to_;                       // the ways of vertices that clusters were searched for
  std::vector<PackedSlabs> still_,
      moving_;  // boxes of vertices at x, and of those ways with their margin
  bool still_at_x_ = false;
  std::vector<int> version_;  // of the trees
  // The vertices of each surface's clusters, each once: those of cluster c are [start[c], start[c +
  // 1]).
  struct Members {
    std::vector<Index> start{0}, vertices;
  };
  std::vector<Members> members_;
  std::vector<std::vector<Motion>> motions_;       // of the clusters of each surface
  std::vector<std::vector<std::uint8_t>> marked_;  // scratch: clusters whose features are needed
  std::vector<NearList> lists_;                    // ascending by surface pair and clusters
  std::vector<std::uint8_t> unlisted_;             // of surface pairs
  std::int64_t n_searches_ = 0, n_made_ = 0;
};

}  // namespace loomstone
