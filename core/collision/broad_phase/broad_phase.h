// Candidate pairs (broad phase): vertex-face and edge-edge pairs whose 18-DOPs overlap, each once.
// Excluded are pairs that share a vertex, pairs without cloth, and self-pairs of cloths without
// self-collision.
#pragma once

#include <functional>
#include <vector>

#include "core/base/types.h"
#include "core/collision/broad_phase/cluster_tree.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/feature_pairs.h"
#include "core/parallel/team.h"

namespace loomstone {

// Receives the pairs of a search in batches as they are found. Threads call take() concurrently,
// each for its own tasks; the numbering of tasks does not depend on the threads.
class PairSink {
 public:
  virtual ~PairSink() = default;
  virtual void prepare(Index n_tasks) = 0;
  virtual void take(Index task, Index surface_pair, ContactKind kind,
                    std::vector<PairKey>& keys) = 0;  // may change the keys
};

// Motion over a step, and the inflation of the boxes around it.
struct Sweep {
  const Points& x0;
  const Points& x1;
  double inflation;          // [m]
  bool may_rebuild = false;  // rebuild trees whose boxes have grown much; affects speed only
};

// Stage: a tree for each surface. Trees affect speed, never results.
class BroadPhase {
 public:
  BroadPhase(const CollisionModel& model, const std::vector<SurfacePair>& pairs);

  // Pairs of features closer than `reach[i]` [m] at x, for the surface pairs i listed in `which`.
  // Existing trees are refitted, never rebuilt.
  void near_pairs(const Team& team, const Points& x, const std::vector<Index>& which,
                  const std::vector<double>& reach, std::vector<FeaturePairs>& found);

  // Pairs of features whose 18-DOPs over the whole step, grown by `inflation` each, meet.
  void swept_pairs(const Team& team, const Sweep& sweep, const std::vector<Index>& which,
                   PairSink& sink);
  // Those of them that keep(kind, keys) retains; it erases the others. Threads call it
  // concurrently.
  using Keep = std::function<void(ContactKind, std::vector<PairKey>&)>;
  void swept_pairs(const Team& team, const Sweep& sweep, const std::vector<Index>& which,
                   const Keep& keep, std::vector<FeaturePairs>& found);

  // Pairs of clusters of a surface pair's trees whose boxes overlap, as (a << 32 | b), ascending.
  // Returns false, without the pairs, if there are more than `most`.
  bool cluster_pairs(const Team& team, Index surface_pair, std::size_t most,
                     std::vector<PairKey>& found) const;
  ClusterTree& tree(Index surface) { return trees_[surface]; }
  // Whether an attachment ties a vertex of one side to the surface of the other.
  bool attached(ContactKind kind, PairKey key) const;

  void forget_trees();  // they are rebuilt when next needed

  std::size_t bytes() const;  // memory of the trees and the boxes of vertices

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
