#include "core/collision/cluster_tree.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

namespace loomstone {

namespace {

// Clusters whose boxes have this many times their area after forming are formed anew. Our choice; only speed depends on it.
constexpr double decay_limit = 1.5;

SlabGroup empty_group() {
  SlabGroup group;
  for (int lane = 0; lane < slab_lanes; ++lane) group.set(lane, empty_slabs());
  return group;
}

Slabs bounds(const SlabGroup& group) {
  Slabs all = group.lane(0);
  for (int lane = 1; lane < slab_lanes; ++lane) all.include(group.lane(lane));
  return all;
}

double area(const Slabs& s, double inflation) {
  double side[3];
  for (int k = 0; k < 3; ++k) side[k] = static_cast<double>(s.high[k]) - s.low[k] - 2.0 * inflation;
  return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
}

// Orders items so that every node is compact: halves along the longest axis, cut where a node of the tree begins.
void order_by_halves(const Points& centres, Index* items, Index n) {
  if (n <= slab_lanes) return;
  Eigen::RowVector3d low = centres.row(items[0]), high = low;
  for (Index i = 1; i < n; ++i) {
    low = low.cwiseMin(centres.row(items[i]));
    high = high.cwiseMax(centres.row(items[i]));
  }
  int axis;
  (high - low).maxCoeff(&axis);
  Index node = slab_lanes;  // items of the largest node that is smaller than all of them
  while (node * slab_lanes < n) node *= slab_lanes;
  const Index half = std::max<Index>(1, (n / 2 + node / 2) / node) * node;
  std::nth_element(items, items + half, items + n, [&](Index i, Index j) {
    return centres(i, axis) != centres(j, axis) ? centres(i, axis) < centres(j, axis) : i < j;
  });
  order_by_halves(centres, items, half);
  order_by_halves(centres, items + half, n - half);
}

}  // namespace

ClusterTree::ClusterTree(Triangles triangles, Index first_triangle, Edges edges, std::vector<Index> edge_ids)
    : triangles_(std::move(triangles)), first_triangle_(first_triangle), edges_(std::move(edges)), edge_ids_(std::move(edge_ids)) {
  n_clusters_ = static_cast<Index>((triangles_.rows() + slab_lanes - 1) / slab_lanes);
  Index n = n_clusters_;
  do {
    n = std::max<Index>(1, (n + slab_lanes - 1) / slab_lanes);
    levels_.emplace_back(n, empty_group());
  } while (n > 1);
}

Slabs ClusterTree::box(int level, Index node) const {
  return level == root_level() ? bounds(levels_.back()[0]) : levels_[level][node / slab_lanes].lane(node % slab_lanes);
}

void ClusterTree::assign(Features& features, const std::vector<Index>& cluster_of_feature, int n_corners,
                         const Index* corners) const {
  std::vector<Index> next(n_clusters_, 0);
  for (const Index c : cluster_of_feature) ++next[c];
  features.group.assign(n_clusters_ + 1, 0);
  for (Index c = 0; c < n_clusters_; ++c) {
    features.group[c + 1] = features.group[c] + (next[c] + slab_lanes - 1) / slab_lanes;
    next[c] = slab_lanes * features.group[c];
  }
  const std::size_t n_groups = features.group[n_clusters_];
  features.slabs.assign(n_groups, empty_group());
  features.id.assign(slab_lanes * n_groups, -1);
  features.n_corners = n_corners;
  features.corners.assign(slab_lanes * n_groups * n_corners, -1);
  for (std::size_t i = 0; i < cluster_of_feature.size(); ++i) {
    const Index slot = next[cluster_of_feature[i]]++;
    features.id[slot] = static_cast<Index>(i);
    Index* const corner = features.corners.data() + static_cast<std::size_t>(slot / slab_lanes) * n_corners * slab_lanes;
    for (int k = 0; k < n_corners; ++k) corner[k * slab_lanes + slot % slab_lanes] = corners[n_corners * i + k];
  }
}

void ClusterTree::rebuild(const Points& x) {
  const Index n = static_cast<Index>(triangles_.rows());
  Points centres(n, 3);
  for (Index t = 0; t < n; ++t)
    centres.row(t) = (x.row(triangles_(t, 0)) + x.row(triangles_(t, 1)) + x.row(triangles_(t, 2))) / 3.0;
  std::vector<Index> order(n), cluster_of_face(n);
  for (Index t = 0; t < n; ++t) order[t] = t;
  order_by_halves(centres, order.data(), n);
  for (Index i = 0; i < n; ++i) cluster_of_face[order[i]] = i / slab_lanes;

  // A vertex or an edge goes to that one of its faces' clusters which owns fewest so far, so that few lanes stay empty.
  std::unordered_map<Index, std::vector<Index>> faces_of;
  std::vector<Index> vertices;
  for (Index t = 0; t < n; ++t)
    for (int k = 0; k < 3; ++k) {
      std::vector<Index>& faces = faces_of[triangles_(t, k)];
      if (faces.empty()) vertices.push_back(triangles_(t, k));
      faces.push_back(t);
    }
  std::vector<Index> owned;
  const auto give = [&](const std::vector<Index>& faces, Index other_vertex) {
    Index cluster = -1;
    for (const Index t : faces) {
      if (other_vertex >= 0 && (triangles_.row(t).array() != other_vertex).all()) continue;
      const Index c = cluster_of_face[t];
      if (cluster < 0 || owned[c] < owned[cluster]) cluster = c;
    }
    ++owned[cluster];
    return cluster;
  };
  std::vector<Index> cluster_of_vertex, cluster_of_edge;
  owned.assign(n_clusters_, 0);
  for (const Index v : vertices) cluster_of_vertex.push_back(give(faces_of[v], -1));
  owned.assign(n_clusters_, 0);
  for (Index e = 0; e < edges_.rows(); ++e) cluster_of_edge.push_back(give(faces_of[edges_(e, 0)], edges_(e, 1)));

  assign(faces_, cluster_of_face, 3, triangles_.data());
  assign(edge_features_, cluster_of_edge, 2, edges_.data());
  assign(vertices_, cluster_of_vertex, 1, vertices.data());
  for (Index& id : faces_.id)
    if (id >= 0) id += first_triangle_;
  for (Index& id : edge_features_.id)
    if (id >= 0) id = edge_ids_[id];
  vertices_.id = std::vector<Index>();
}

double ClusterTree::refit_all(const Team& team, const std::vector<Slabs>& vertices, double inflation) {
  for (Features* const features : {&faces_, &edge_features_, &vertices_})
    parallel_for(
        team, static_cast<Index>(features->slabs.size()),
        [&](Index g) {
          const int n = features->n_corners;
          const Index* const corners = features->corners.data() + static_cast<std::size_t>(g) * n * slab_lanes;
          for (int lane = 0; lane < slab_lanes && corners[lane] >= 0; ++lane) {
            Slabs slabs = vertices[corners[lane]];
            for (int k = 1; k < n; ++k) slabs.include(vertices[corners[k * slab_lanes + lane]]);
            features->slabs[g].set(lane, slabs);
          }
        },
        256);
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    const std::vector<SlabGroup>& below = level == 0 ? faces_.slabs : levels_[level - 1];
    parallel_for(
        team, static_cast<Index>(below.size()),
        [&](Index child) { levels_[level][child / slab_lanes].set(child % slab_lanes, bounds(below[child])); }, 256);
  }
  double sum = 0.0;
  for (Index c = 0; c < n_clusters_; ++c) sum += area(box(0, c), inflation);
  return sum;
}

void ClusterTree::refit(const Team& team, const Points& x, const std::vector<Slabs>& vertices, double inflation,
                        bool may_rebuild) {
  if (empty()) return;
  if (built_area_ >= 0.0) {
    const double now = refit_all(team, vertices, inflation);
    if (!may_rebuild || now <= decay_limit * built_area_) return;
  }
  rebuild(x);
  built_area_ = std::max(0.0, refit_all(team, vertices, inflation));
}

std::size_t ClusterTree::bytes() const {
  std::size_t n = 0;
  for (const Features* const f : {&faces_, &edge_features_, &vertices_})
    n += f->slabs.capacity() * sizeof(SlabGroup) + (f->id.capacity() + f->group.capacity() + f->corners.capacity()) * sizeof(Index);
  for (const auto& level : levels_) n += level.capacity() * sizeof(SlabGroup);
  return n;
}

}  // namespace loomstone
