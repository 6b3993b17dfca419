// Vertices of the clusters of a tree, and the motion of clusters.
#pragma once

#include <atomic>
#include <vector>

#include "core/base/bytes.h"
#include "core/collision/broad_phase/cluster_tree.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

// For each cluster of one surface, the vertices of the features in the cluster.
class ClusterMembers {
 public:
  ClusterMembers() = default;
  explicit ClusterMembers(const ClusterTree& tree);

  Index n_clusters() const { return static_cast<Index>(start_.size()) - 1; }
  // Calls visit(vertex) for each vertex of a cluster.
  template <class Visit>
  void each(Index cluster, Visit&& visit) const {
    for (Index i = start_[cluster]; i < start_[cluster + 1]; ++i) visit(vertices_[i]);
  }
  std::size_t bytes() const { return bytes_of(start_, vertices_); }

 private:
  // The vertices of cluster c are the entries start_[c] to start_[c + 1] - 1 of vertices_.
  std::vector<Index> start_{0}, vertices_;
};

// A set of vertices that is filled and emptied often.
class VertexSet {
 public:
  explicit VertexSet(Index n_vertices) : inside_(n_vertices, 0) {}

  void add(Index vertex) {
    if (inside_[vertex]) return;
    inside_[vertex] = 1;
    vertices_.push_back(vertex);
  }
  // Adds a vertex to the set, but not to vertices(). Returns true if this call added the vertex,
  // and false if the set already contained it. Several threads may call this function at once.
  // Afterwards, the caller must pass the added vertices to list().
  bool take(Index vertex) {
    std::atomic_ref<std::uint8_t> inside(inside_[vertex]);
    return !inside.load(std::memory_order_relaxed) &&
           !inside.exchange(1, std::memory_order_relaxed);
  }
  void list(const std::vector<Index>& taken) {
    vertices_.insert(vertices_.end(), taken.begin(), taken.end());
  }
  void clear() {
    for (const Index v : vertices_) inside_[v] = 0;
    vertices_.clear();
  }
  const std::vector<Index>& vertices() const { return vertices_; }  // in the order of addition
  std::size_t bytes() const { return bytes_of(inside_, vertices_); }

 private:
  std::vector<std::uint8_t> inside_;
  std::vector<Index> vertices_;
};

// Ball |d - centre| <= radius that contains the displacements d of all vertices of a cluster.
struct ClusterMotion {
  Vec3 centre = Vec3::Zero();  // [m]
  double radius = 0.0;         // [m]
};

// Returns the motion of a cluster while vertices move from x0 to x1.
ClusterMotion cluster_motion(const ClusterMembers& members, Index cluster, const Points& x0,
                             const Points& x1);

}  // namespace loomstone
