#include "core/magnetics/fast_sums/expanded_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/message.h"
#include "core/base/simd.h"

namespace loomstone {

namespace {

// Half the edge length of the root cube of the octree, divided by the radius of the source [1].
// Outside this cube, the multipole expansion is used. Its error at two radii and beyond is stated
// in multipole_expansion.h.
constexpr double reach = 2.0;

ExpansionSetting setting_for(const SourceGroups& source, double tolerance) {
  for (const ExpansionSetting& setting : source.settings())
    if (setting.error <= tolerance && tolerance <= 0.1) return setting;
  fail<InvalidInput>("tolerance must be in [3e-7, 0.1] [1], got {}", tolerance);
}

}  // namespace

ExpandedField::ExpandedField(std::unique_ptr<SourceGroups> source, double tolerance)
    : source_(std::move(source)),
      expansion_(setting_for(*source_, tolerance).order),
      opening_(setting_for(*source_, tolerance).opening) {
  std::vector<Index> parts(source_->n_parts());
  std::iota(parts.begin(), parts.end(), 0);
  add_cluster(parts, 0, parts.size());
  cubes_.push_back({Vec3::Zero(), reach * source_->radius()});
  divide(0, {0}, std::vector<double>(expansion_.local_size()));
  locals_.resize(locals_.size() + TaylorExpansion::beyond);
}

// Adds the cluster of parts [begin, end) and its descendants, and returns its index. A cluster of
// more than eight parts is bisected along the longest axis of the bounding box of the parts'
// centres. Its first child has about half of the parts; their number is a multiple of eight.
Index ExpandedField::add_cluster(std::vector<Index>& parts, std::size_t begin, std::size_t end) {
  Vec3 low = source_->middle(parts[begin]), high = low;
  for (std::size_t i = begin; i < end; ++i) {
    low = low.cwiseMin(source_->middle(parts[i]));
    high = high.cwiseMax(source_->middle(parts[i]));
  }
  Cluster cluster{0.5 * (low + high), 0.0};
  for (std::size_t i = begin; i < end; ++i)
    cluster.radius = std::max(cluster.radius, source_->reach(parts[i], cluster.centre));
  const Index self = static_cast<Index>(clusters_.size());
  const std::size_t stride = expansion_.moments_size();
  moments_.resize(moments_.size() + stride, 0.0);
  if (end - begin <= n_lanes) {
    cluster.group = static_cast<Index>(group_radii_.size());
    clusters_.push_back(cluster);
    group_radii_.push_back(cluster.radius);
    source_->add(parts.data() + begin, static_cast<Index>(end - begin), expansion_, cluster.centre,
                 moments_.data() + self * stride);
    return self;
  }
  clusters_.push_back(cluster);
  int axis;
  (high - low).maxCoeff(&axis);
  const std::size_t half = ((end - begin) / 2 + n_lanes - 1) / n_lanes * n_lanes;
  std::nth_element(parts.begin() + begin, parts.begin() + begin + half, parts.begin() + end,
                   [&](Index a, Index b) {
                     const double xa = source_->middle(a)[axis], xb = source_->middle(b)[axis];
                     return xa < xb || (xa == xb && a < b);
                   });
  const Index children[2] = {add_cluster(parts, begin, begin + half),
                             add_cluster(parts, begin + half, end)};
  for (int k = 0; k < 2; ++k) {
    clusters_[self].children[k] = children[k];
    expansion_.add_moments(moments_.data() + children[k] * stride,
                           cluster.centre - clusters_[children[k]].centre,
                           moments_.data() + self * stride);
  }
  return self;
}

// Classifies candidate clusters as far from a sphere or near it. Near clusters with children are
// opened if they are larger than the sphere. If `leaf` is true, all near clusters with children are
// opened, and Sorted::near contains indices of groups instead of clusters.
ExpandedField::Sorted ExpandedField::sorted(const Vec3& centre, double radius,
                                            const std::vector<Index>& candidates, bool leaf) const {
  Sorted result;
  std::vector<Index> open = candidates;
  for (std::size_t i = 0; i < open.size(); ++i) {
    const Cluster& cluster = clusters_[open[i]];
    const Vec3 arm = centre - cluster.centre;
    const double sum = radius + cluster.radius;
    if (sum * sum < opening_ * opening_ * arm.squaredNorm()) {
      const double* moments =
          moments_.data() + static_cast<std::size_t>(open[i]) * expansion_.moments_size();
      result.far.push_back({moments, {arm[0], arm[1], arm[2]}});
    } else if (cluster.group >= 0) {
      result.near.push_back(leaf ? cluster.group : open[i]);
    } else if (leaf || cluster.radius > radius) {
      open.insert(open.end(), cluster.children, cluster.children + 2);
    } else {
      result.near.push_back(open[i]);
    }
  }
  return result;
}

// A cube becomes a leaf if at most SourceGroups::few() groups are near it, or if the radius of its
// circumscribed sphere is less than 0.6 times the mean radius of the near groups. Smaller leaves
// would speed up evaluation, but would need more setup time and memory.
void ExpandedField::divide(Index cube, const std::vector<Index>& candidates,
                           const std::vector<double>& inherited) {
  const Vec3 centre = cubes_[cube].centre;
  const double radius = std::sqrt(3.0) * cubes_[cube].half;
  std::vector<double> local = inherited;
  const auto add = [&](const Sorted& sides) {
    if (!sides.far.empty())
      expansion_.add_far(sides.far.data(), static_cast<Index>(sides.far.size()), local.data());
    expansion_.complete(local.data());
  };
  const Sorted whole = sorted(centre, radius, candidates, true);
  double size = 0.0;
  for (const Index group : whole.near) size += group_radii_[group];
  if (static_cast<Index>(whole.near.size()) <= source_->few() ||
      radius * whole.near.size() < 0.6 * size) {
    add(whole);
    Cube& leaf = cubes_[cube];
    leaf.local = static_cast<Index>(locals_.size() / expansion_.local_size());
    locals_.resize(locals_.size() + local.size());
    expansion_.pack(local.data(), locals_.data() + locals_.size() - local.size());
    leaf.begin = static_cast<Index>(nearest_.size());
    nearest_.insert(nearest_.end(), whole.near.begin(), whole.near.end());
    leaf.end = static_cast<Index>(nearest_.size());
    return;
  }
  const Sorted rest = sorted(centre, radius, candidates, false);
  add(rest);
  const Index child = static_cast<Index>(cubes_.size());
  cubes_[cube].child = child;
  const double half = 0.5 * cubes_[cube].half;
  for (int k = 0; k < 8; ++k)
    cubes_.push_back({centre + half * Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1), half});
  for (int k = 0; k < 8; ++k) {
    std::vector<double> shifted(expansion_.local_size());
    expansion_.add_local(local.data(), cubes_[child + k].centre - centre, shifted.data());
    divide(child + k, rest.near, shifted);
  }
}

Index ExpandedField::leaf_at(const Vec3& point) const {
  if (!(point.cwiseAbs().maxCoeff() < cubes_[0].half)) return -1;
  Index cube = 0;
  while (cubes_[cube].child >= 0) {
    const Vec3& c = cubes_[cube].centre;
    cube = cubes_[cube].child + (point[0] > c[0] ? 1 : 0) + (point[1] > c[1] ? 2 : 0) +
           (point[2] > c[2] ? 4 : 0);
  }
  return cube;
}

void ExpandedField::field_and_gradient_block(const double* points, Index n, double* field,
                                             double* gradient) const {
  Index beyond[points_per_block], n_beyond = 0;
  for (Index i = 0; i < n; ++i) {
    const Vec3 point(points[i], points[n + i], points[2 * n + i]);
    const Index leaf = leaf_at(point);
    if (leaf < 0) {
      beyond[n_beyond++] = i;
      continue;
    }
    const Cube& cube = cubes_[leaf];
    double b[3], g[6], near[3], near_gradient[6];
    expansion_.evaluate_at(
        locals_.data() + static_cast<std::size_t>(cube.local) * expansion_.local_size(),
        cube.centre, point.data(), b, g);
    source_->sum({nearest_.data() + cube.begin, cube.end - cube.begin}, point.data(), near,
                 near_gradient);
    for (int c = 0; c < 3; ++c) field[c * n + i] = b[c] + near[c];
    for (int c = 0; c < 6; ++c) gradient[c * n + i] = g[c] + near_gradient[c];
  }
  for (Index begin = 0; begin < n_beyond; begin += n_lanes) {
    alignas(64) double x[3 * n_lanes], b[3 * n_lanes], g[6 * n_lanes];
    const Index count = std::min<Index>(n_lanes, n_beyond - begin);
    for (int lane = 0; lane < n_lanes; ++lane)
      for (int c = 0; c < 3; ++c)
        x[c * n_lanes + lane] = points[c * n + beyond[begin + std::min<Index>(lane, count - 1)]];
    source_->multipoles().field_block(x, n_lanes, b);
    source_->multipoles().gradient_block(x, n_lanes, g);
    for (int lane = 0; lane < count; ++lane) {
      for (int c = 0; c < 3; ++c) field[c * n + beyond[begin + lane]] = b[c * n_lanes + lane];
      for (int c = 0; c < 6; ++c) gradient[c * n + beyond[begin + lane]] = g[c * n_lanes + lane];
    }
  }
}

void ExpandedField::field_block(const double* points, Index n, double* field) const {
  double gradient[6 * points_per_block];
  field_and_gradient_block(points, n, field, gradient);
}

void ExpandedField::gradient_block(const double* points, Index n, double* gradient) const {
  double field[3 * points_per_block];
  field_and_gradient_block(points, n, field, gradient);
}

}  // namespace loomstone
