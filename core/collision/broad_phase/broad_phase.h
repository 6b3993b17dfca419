// Broad phase: finds all vertex-face and edge-edge pairs whose 18-DOPs overlap, and reports each
// pair once. Excludes pairs of features that share a vertex and pairs that do not collide because
// of an attachment. surface_pairs() has already excluded pairs of surfaces neither of which is
// cloth, and self-collisions that are switched off. near_pairs() also excludes pairs beyond a given
// distance.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/types.h"
#include "core/collision/broad_phase/cluster_tree.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/feature_pairs.h"
#include "core/parallel/shared_work.h"
#include "core/parallel/team.h"

namespace loomstone {

// Receives the pairs of a search in batches. Each task runs on one thread, but threads call take()
// concurrently for different tasks. Task indices do not depend on the number of threads.
class PairSink {
 public:
  virtual ~PairSink() = default;
  virtual void prepare(Index n_tasks) = 0;
  virtual void take(Index task, Index surface_pair, ContactKind kind,
                    std::vector<PairKey>& keys) = 0;  // may change `keys`
};

// Motion over a step, and the inflation of the bounding volumes that enclose it.
struct Sweep {
  const Points& x0;
  const Points& x1;
  double inflation;  // [m]
  // If true, trees whose boxes have grown too much are rebuilt. This does not affect which pairs
  // are found.
  bool may_rebuild = false;
};

// The tasks of a search that a rank performs: every `size`-th task, beginning with task `rank`.
struct TaskShare {
  int rank = 0, size = 1;
};

// Broad phase with one tree for each surface. The shape of the trees does not affect which pairs
// are found.
class BroadPhase {
 public:
  // near_pairs() and swept_pairs() find only the pairs that belong to the tasks in `share`.
  BroadPhase(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
             TaskShare share = {});

  // Sets found[i] to the pairs of features that are at most reach[i] [m] apart at x, for each
  // surface pair i in `which`. Existing trees are refitted but not rebuilt.
  void near_pairs(const Team& team, const Points& x, const std::vector<Index>& which,
                  const std::vector<double>& reach, std::vector<FeaturePairs>& found);

  // Passes to `sink` all feature pairs with overlapping 18-DOPs, for the surface pairs in `which`.
  // The 18-DOPs enclose the motion from sweep.x0 to sweep.x1 and are inflated by sweep.inflation.
  void swept_pairs(const Team& team, const Sweep& sweep, const std::vector<Index>& which,
                   PairSink& sink);
  // Like the other swept_pairs(), but stores the pairs of surface pair i in found[i]. `keep` is
  // called for each batch of pairs and removes unwanted ones. Threads call `keep` concurrently.
  using Keep = std::function<void(ContactKind, std::vector<PairKey>&)>;
  void swept_pairs(const Team& team, const Sweep& sweep, const std::vector<Index>& which,
                   const Keep& keep, std::vector<FeaturePairs>& found);

  // Returns the pairs (a, b) of clusters whose boxes in the trees overlap, without refitting the
  // trees. Cluster a belongs to the first surface of the surface pair and lies in the range
  // `first`; cluster b belongs to the second surface. The pairs are packed as a << 32 | b, in
  // ascending order. If there are more than `most` pairs, more than `most` are returned, but some
  // may be missing.
  std::vector<PairKey> cluster_pairs(const Team& team, Index surface_pair, IndexRange first,
                                     std::size_t most) const;
  ClusterTree& tree(Index surface) { return trees_[surface]; }
  // Memory for vertex boxes. All callers share it, and near_pairs() and swept_pairs() replace its
  // contents.
  VertexBoxes& vertex_boxes() { return vertex_boxes_; }
  // Returns whether two features do not collide because a vertex of one of them is attached to the
  // surface of the other one, with AttachedTo::distance 0.
  bool attached(ContactKind kind, PairKey key) const;

  void forget_trees();  // each tree is rebuilt at its next refit

  std::size_t bytes() const;  // memory of trees and vertex boxes [bytes]

 private:
  bool compares_all(const std::vector<Index>& which) const;
  void refit(const Team& team, Index surface, const Sweep& sweep, bool features);
  struct Task;
  std::vector<Task> deal_out(const std::vector<Index>& which, IndexRange first) const;
  std::vector<std::vector<PairKey>> clusters_of(const Team& team, const std::vector<Task>& tasks);
  void search(const Team& team, const std::vector<Index>& which, PairSink& sink);

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  std::vector<ClusterTree> trees_;  // one for each surface
  VertexBoxes vertex_boxes_;
  TaskShare share_;
};

}  // namespace loomstone
