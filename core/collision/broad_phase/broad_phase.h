// Which vertex-face and edge-edge pairs of which surfaces may meet: pairs of overlapping 18-DOPs,
// each pair once, without pairs that share a vertex, that only scripts and rigid bodies could move,
// or that a cloth's own switch rules out.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/types.h"
#include "core/collision/broad_phase/cluster_tree.h"
#include "core/collision/collision_stage.h"
#include "core/collision/model/collision_model.h"
#include "core/parallel/team.h"

namespace loomstone {

// Two surfaces of which at least the first is cloth; a == b: a cloth with itself.
struct SurfacePair {
  Index a, b;
  double thickness;  // xi of the pair: the mean [m]
  double friction;   // mu of the pair: the geometric mean [1]
};

std::vector<SurfacePair> surface_pairs(const CollisionModel& model);

// Pairs of features as (a << 32 | b): vertex and triangle, or two edges with a < b. Ascending.
using PairKey = std::uint64_t;
inline PairKey pair_key(Index a, Index b) {
  return static_cast<PairKey>(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
}
inline Index first_of(PairKey key) { return static_cast<Index>(key >> 32); }
inline Index second_of(PairKey key) { return static_cast<Index>(key & 0xffffffffu); }

struct FeaturePairs {
  std::vector<PairKey> vertex_face, edge_edge;
};

inline std::array<Index, 4> pair_vertices(const CollisionModel& model, ContactKind kind,
                                          PairKey key) {
  const Index a = first_of(key), b = second_of(key);
  if (kind == ContactKind::VertexFace)
    return {a, model.triangles(b, 0), model.triangles(b, 1), model.triangles(b, 2)};
  return {model.edges(a, 0), model.edges(a, 1), model.edges(b, 0), model.edges(b, 1)};
}

// Takes the pairs of a search in batches as they are found. Several threads call take() at once,
// each for tasks of its own; tasks are numbered in an order that threads do not change.
class PairSink {
 public:
  virtual ~PairSink() = default;
  virtual void prepare(Index n_tasks) = 0;
  virtual void take(Index task, Index surface_pair, ContactKind kind,
                    std::vector<PairKey>& keys) = 0;  // may change the keys
};

// Stage: a tree of every surface, and scratch that decides nothing.
class BroadPhase {
 public:
  BroadPhase(const CollisionModel& model, const std::vector<SurfacePair>& pairs);

  // Pairs of features closer than `reach[i]` [m] at x, of those surface pairs i that are named in
  // `which`. Trees that exist stay.
  void near_pairs(const Team& team, const Points& x, const std::vector<Index>& which,
                  const std::vector<double>& reach, std::vector<FeaturePairs>& found);

  // Pairs of features whose 18-DOPs over the whole step, grown by `inflation` [m] each, meet.
  // `may_rebuild`: trees whose boxes have grown much since they were formed are formed anew, which
  // changes speed and nothing else.
  void swept_pairs(const Team& team, const Points& x0, const Points& x1, double inflation,
                   const std::vector<Index>& which, bool may_rebuild, PairSink& sink);
  // Those of them that are left by keep(kind, keys), which takes out the others and which several
  // threads call at once.
  using Keep = std::function<void(ContactKind, std::vector<PairKey>&)>;
  void swept_pairs(const Team& team, const Points& x0, const Points& x1, double inflation,
                   const std::vector<Index>& which, const Keep& keep,
                   std::vector<FeaturePairs>& found);

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
  void refit(const Team& team, Index surface, const Points& x0, const Points& x1, double inflation,
             bool may_rebuild);
  struct Task;
  std::vector<Task> deal_out(const std::vector<Index>& which) const;
  void search(const Team& team, const std::vector<Index>& which, PairSink& sink);

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  std::vector<ClusterTree> trees_;  // of each surface
  std::vector<PackedSlabs> vertex_slabs_;
};

}  // namespace loomstone
