// Which vertex-face and edge-edge pairs of which surfaces may meet: pairs of overlapping 18-DOPs,
// each pair once, without pairs that share a vertex, that only scripts and rigid bodies could move,
// or that a cloth's own switch rules out.
#pragma once

#include <functional>
#include <vector>

#include "core/base/types.h"
#include "core/collision/broad_phase/cluster_tree.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/feature_pairs.h"
#include "core/parallel/team.h"

namespace loomstone {

// Takes the pairs of a search in batches as they are found. Several threads call take() at once,
// each for tasks of its own; tasks are numbered in an order that threads do not change.
class PairSink {
 public:
  virtual ~PairSink() = default;
  virtual void prepare(Index n_tasks) = 0;
  virtual void take(Index task, Index surface_pair, ContactKind kind,
                    std::vector<PairKey>& keys) = 0;  // may change the keys
};

// Motion over a step, and by how much boxes are grown.
struct Sweep {
  const Points& x0;
  const Points& x1;
  double inflation;          // [m]
  bool may_rebuild = false;  // trees whose boxes have grown much since they were formed are formed
                             // anew, which changes speed and nothing else
};

// Stage: a tree of every surface, and scratch that decides nothing.
class BroadPhase {
 public:
  BroadPhase(const CollisionModel& model, const std::vector<SurfacePair>& pairs);

  // Pairs of features closer than `reach[i]` [m] at x, of those surface pairs i that are named in
  // `which`. Trees that exist stay.
  void near_pairs(const Team& team, const Points& x, const std::vector<Index>& which,
                  const std::vector<double>& reach, std::vector<FeaturePairs>& found);

  // Pairs of features whose 18-DOPs over the whole step, grown by `inflation` each, meet.
  void swept_pairs(const Team& team, const Sweep& sweep, const std::vector<Index>& which,
                   PairSink& sink);
  // Those of them that are left by keep(kind, keys), which takes out the others and which several
  // threads call at once.
  using Keep = std::function<void(ContactKind, std::vector<PairKey>&)>;
  void swept_pairs(const Team& team, const Sweep& sweep, const std::vector<Index>& which,
                   const Keep& keep, std::vector<FeaturePairs>& found);

  // Pairs of clusters of a surface pair's trees whose boxes overlap, as (a << 32 | b), ascending;
  // false (and some of them) where there are more than `most`.
  bool cluster_pairs(const Team& team, Index surface_pair, std::size_t most,
                     std::vector<PairKey>& found) const;
  ClusterTree& tree(Index surface) { return trees_[surface]; }
  // Is a vertex of one side attached to the other's surface?
  bool attached(ContactKind kind, PairKey key) const;

  void forget_trees();  // forms all anew when they are next needed

  std::size_t bytes() const;  // of all trees and boxes of vertices

 private:
  void refit(const Team& team, Index surface, const Sweep& sweep);
  struct Task;
  std::vector<Task> deal_out(const std::vector<Index>& which) const;
  void search(const Team& team, const std::vector<Index>& which, PairSink& sink);

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  std::vector<ClusterTree> trees_;  // of each surface
  std::vector<PackedSlabs> vertex_slabs_;
};

}  // namespace loomstone
