// Refit of the node boxes of cluster trees by several ranks. Each rank computes the boxes of a
// share of the clusters. All ranks then receive all boxes of clusters and compute those of the
// nodes.
#pragma once

#include <vector>

#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/broad_phase/cluster_members.h"

namespace loomstone {

// A box of vertex v of a surface: `box(surface, v)`.
using VertexBox = std::function<PackedSlabs(Index surface, Index vertex)>;

class SharedRefit {
 public:
  SharedRefit(const CollisionModel& model, BroadPhase& broad_phase, const Communicator& ranks);

  // Collective. Recomputes the node boxes of all trees from vertex boxes `moving`. Forms clusters
  // at x where a tree has none and, if `may_rebuild`, where the boxes at x have grown too much.
  // Returns whether the clusters of each surface have changed since the last call.
  std::vector<std::uint8_t> refit(const Team& team, const Points& x, const VertexBox& moving,
                                  bool may_rebuild);
  // Returns whether the clusters of any surface have changed since the last refit().
  bool other_trees() const;

  const ClusterMembers& members(Index surface) const { return surfaces_[surface].members; }

 private:
  struct Surface {
    ClusterMembers members;
    int version = 0;                 // version of the tree in the last refit()
    std::vector<Index> vertices;     // vertices of the clusters of this rank's share
    std::vector<PackedSlabs> boxes;  // scratch: boxes of all clusters
  };

  bool shared(Index surface) const;
  IndexRange share(Index surface, int rank) const;
  void form(Index surface, const Points& x);
  void find_members(Index surface);
  void find_boxes(const Team& team, const std::vector<Index>& which, const VertexBox& box);

  BroadPhase& broad_phase_;
  const Communicator& ranks_;
  std::vector<Surface> surfaces_;
  std::vector<PackedSlabs> vertices_;  // scratch: boxes of the vertices of this rank's share
  VertexSet set_;                      // scratch
};

}  // namespace loomstone
