#include "core/collision/broad_phase/cluster_members.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

ClusterMembers::ClusterMembers(const ClusterTree& tree) {
  const Index* const corners = tree.faces().corners.data();
  for (Index c = 0; c < tree.n_clusters(); ++c) {
    const auto begin = vertices_.insert(vertices_.end(), corners + 3 * slab_lanes * c,
                                        corners + 3 * slab_lanes * (c + 1));
    std::sort(begin, vertices_.end());
    vertices_.erase(std::unique(begin, vertices_.end()), vertices_.end());
    const auto none = vertices_.begin() + start_.back();  // *none is -1 if some lanes are empty
    if (none != vertices_.end() && *none < 0) vertices_.erase(none);
    start_.push_back(static_cast<Index>(vertices_.size()));
  }
}

ClusterMotion cluster_motion(const ClusterMembers& members, Index cluster, const Points& x0,
                             const Points& x1) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  members.each(cluster, [&](Index v) {
    for (int k = 0; k < 3; ++k) {
      const double d = x1(v, k) - x0(v, k);
      low[k] = std::min(low[k], d);
      high[k] = std::max(high[k], d);
    }
  });
  ClusterMotion motion;
  double square = 0.0;
  for (int k = 0; k < 3; ++k) {
    motion.centre[k] = 0.5 * (low[k] + high[k]);
    square += 0.25 * (high[k] - low[k]) * (high[k] - low[k]);
  }
  motion.radius = std::sqrt(square);
  return motion;
}

}  // namespace loomstone
