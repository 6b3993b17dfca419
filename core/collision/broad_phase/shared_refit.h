// Refit of the node boxes of cluster trees by several ranks. Each rank computes the boxes of a part
// of the clusters. All ranks then receive the boxes of all clusters and compute those of the nodes
// above them. For trees with few clusters, every rank computes all boxes.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/broad_phase/cluster_members.h"

namespace loomstone {

// Function (surface, vertex) that returns the box of a vertex of a surface.
using VertexBox = std::function<PackedSlabs(Index surface, Index vertex)>;

class SharedRefit {
 public:
  SharedRefit(const CollisionModel& model, BroadPhase& broad_phase, const Communicator& ranks);

  // Collective. First forms clusters at x in trees without clusters and, if `may_rebuild` is set,
  // in trees whose boxes at x have grown too much (ClusterTree::has_grown()). Then recomputes the
  // node boxes of all trees from the vertex boxes that `moving` returns. Returns for each surface 1
  // if its clusters have changed since the last call, and 0 otherwise.
  std::vector<std::uint8_t> refit(const Team& team, const Points& x, const VertexBox& moving,
                                  bool may_rebuild);
  // Returns whether the clusters of any surface have changed since the last refit().
  bool other_trees() const;

  const ClusterMembers& members(Index surface) const { return surfaces_[surface].members; }
  std::size_t bytes() const { return bytes_of(surfaces_, set_); }

 private:
  struct Surface {
    ClusterMembers members;
    int version = 0;                 // version of the tree at the end of the last refit()
    std::vector<Index> vertices;     // vertices of the clusters whose boxes this rank computes
    std::vector<PackedSlabs> boxes;  // boxes of all clusters; empty outside refit()
    std::size_t bytes() const { return bytes_of(members, vertices, boxes); }
  };

  bool shared(Index surface) const;
  IndexRange share(Index surface, int rank) const;
  void form(Index surface, const Points& x);
  void find_members(Index surface);
  void find_boxes(const Team& team, const std::vector<Index>& which, const VertexBox& box);

  BroadPhase& broad_phase_;
  const Communicator& ranks_;
  std::vector<Surface> surfaces_;
  VertexSet set_;  // scratch
};

}  // namespace loomstone
