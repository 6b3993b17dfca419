#include "core/collision/broad_phase/cluster_members.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

ClusterMembers::ClusterMembers(const ClusterTree& tree) {
  for (Index c = 0; c < tree.n_clusters(); ++c) {
    tree.each_corner(c, [&](Index vertex) { vertices_.push_back(vertex); });
    const auto begin = vertices_.begin() + start_.back();
    std::sort(begin, vertices_.end());
    vertices_.erase(std::unique(begin, vertices_.end()), vertices_.end());
    start_.push_back(static_cast<Index>(vertices_.size()));
  }
  vertices_.shrink_to_fit();
  start_.shrink_to_fit();
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
