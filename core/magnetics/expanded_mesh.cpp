#include "core/magnetics/expanded_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "core/base/error.h"
#include "core/magnetics/flat_face.h"
#include "core/magnetics/gauss.h"

namespace loomstone {

namespace {

// Two things are far apart where the sum of their radii is at most `opening` times the distance of their centres.
struct Setting {
  int order;
  double opening, error;
};
// Errors are those of gradients on a ring of 3,200 faces, of the largest at as many millimetres from its surface, times 1.5.
constexpr Setting settings[] = {{7, 0.55, 4e-3}, {9, 0.5, 3e-4}, {11, 0.4, 3e-5}, {14, 0.35, 3e-7}};

// Beyond so many radii multipoles serve as well: 2^-24 is 6e-8.
constexpr double reach = 2.0;

// Eight groups take about as long as an expansion.
constexpr Index few_groups = 8;

// A table of eight faces: three corners, unit normal, twice the area, charge / 4 pi; then for each edge its ends, length,
// charge / 4 pi times its normal in the face and that of the face.
constexpr int face_rows = 14, edge_rows = 13, group_size = (face_rows + 3 * edge_rows) * n_lanes;

const Setting& setting_for(double tolerance) {
  for (const Setting& setting : settings)
    if (setting.error <= tolerance) return setting;
  throw InvalidInput("tolerance must be in [3e-7, 0.1] [1], got " + std::to_string(tolerance));
}

// Field and gradient of groups of faces at one point.
LOOMSTONE_CLONES void group_kernel(const double* tables, const Index* groups, Index n_groups, double radius,
                                   const double* point, double* field, double* gradient) {
  const Lanes3 p{lanes_all(point[0]), lanes_all(point[1]), lanes_all(point[2])};
  Lanes h[3], g[6];
  for (Lanes& s : h) s = lanes_all(0.0);
  for (Lanes& s : g) s = lanes_all(0.0);
  for (Index k = 0; k < n_groups; ++k) {
    const double* row = tables + static_cast<std::size_t>(groups[k]) * group_size;
    Lanes f[face_rows];
    for (Lanes& value : f) value = lanes_load(row), row += n_lanes;
    const Lanes angle = f[13] * solid_angle(p, f, on_face * radius);
    for (int c = 0; c < 3; ++c) h[c] += f[9 + c] * angle;
    for (int edge = 0; edge < 3; ++edge) {
      Lanes e[edge_rows];
      for (Lanes& value : e) value = lanes_load(row), row += n_lanes;
      const EdgeTerms t = edge_terms(p, e, on_edge * radius);
      const Lanes log = lanes_log(t.sum / t.defect);
      for (int c = 0; c < 3; ++c) h[c] += e[7 + c] * log;
      add_edge_gradients(edge_gradients(t, e), e + 7, e + 10, g);
    }
  }
  const auto sum = [](const Lanes& a) { return ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7])); };
  for (int c = 0; c < 3; ++c) field[c] = sum(h[c]);
  for (int c = 0; c < 6; ++c) gradient[c] = sum(g[c]);
}

}  // namespace

ExpandedMesh::ExpandedMesh(std::shared_ptr<const Polyhedron> mesh, double tolerance)
    : mesh_(std::move(mesh)), expansion_(setting_for(tolerance).order), opening_(setting_for(tolerance).opening) {
  group_faces();
  cubes_.push_back({Vec3::Zero(), reach * mesh_->radius()});
  divide(0, {0}, std::vector<double>(expansion_.local_size()));
}

void ExpandedMesh::group_faces() {
  const Points& x = mesh_->vertices();
  std::vector<Vec3> corners;
  std::vector<Index> faces;
  for (Index t = 0; t < mesh_->triangles().rows(); ++t) {
    for (int k = 0; k < 3; ++k) corners.push_back(x.row(mesh_->triangles()(t, k)).transpose());
    const Vec3* c = corners.data() + 3 * t;
    if ((c[1] - c[0]).cross(c[2] - c[0]).dot(mesh_->polarization()) != 0.0) faces.push_back(t);
  }
  add_cluster(corners, faces, 0, faces.size());
}

// Halves the faces between equally many, in eights, along the longest axis of their centres' box.
Index ExpandedMesh::add_cluster(const std::vector<Vec3>& corners, std::vector<Index>& faces, std::size_t begin,
                                std::size_t end) {
  const auto middle_of = [&](Index t) { return Vec3((corners[3 * t] + corners[3 * t + 1] + corners[3 * t + 2]) / 3.0); };
  Vec3 low = middle_of(faces[begin]), high = low;
  for (std::size_t i = begin; i < end; ++i) {
    low = low.cwiseMin(middle_of(faces[i]));
    high = high.cwiseMax(middle_of(faces[i]));
  }
  Cluster cluster{0.5 * (low + high), 0.0};
  for (std::size_t i = begin; i < end; ++i)
    for (int k = 0; k < 3; ++k)
      cluster.radius = std::max(cluster.radius, (corners[3 * faces[i] + k] - cluster.centre).norm());
  const Index self = static_cast<Index>(clusters_.size());
  const std::size_t stride = expansion_.moments_size();
  moments_.resize(moments_.size() + stride, 0.0);
  if (end - begin <= n_lanes) {
    cluster.group = static_cast<Index>(groups_.size() / group_size);
    clusters_.push_back(cluster);
    group_radii_.push_back(cluster.radius);
    add_group(corners, faces.data() + begin, static_cast<Index>(end - begin));
    return self;
  }
  clusters_.push_back(cluster);
  int axis;
  (high - low).maxCoeff(&axis);
  const std::size_t half = ((end - begin) / 2 + n_lanes - 1) / n_lanes * n_lanes;
  std::nth_element(faces.begin() + begin, faces.begin() + begin + half, faces.begin() + end, [&](Index a, Index b) {
    const double xa = middle_of(a)[axis], xb = middle_of(b)[axis];
    return xa < xb || (xa == xb && a < b);
  });
  const Index children[2] = {add_cluster(corners, faces, begin, begin + half), add_cluster(corners, faces, begin + half, end)};
  for (int k = 0; k < 2; ++k) {
    clusters_[self].children[k] = children[k];
    expansion_.add_moments(moments_.data() + children[k] * stride, cluster.centre - clusters_[children[k]].centre,
                           moments_.data() + self * stride);
  }
  return self;
}

// Table and moments of the faces of the last cluster. Lanes without a face repeat the first without its charge.
void ExpandedMesh::add_group(const std::vector<Vec3>& corners, const Index* faces, Index n) {
  const GaussRule& rule = gauss_rule(expansion_.order() / 2 + 1);
  std::vector<double> positions, charges;
  groups_.resize(groups_.size() + group_size);
  double* table = groups_.data() + groups_.size() - group_size;
  for (int lane = 0; lane < n_lanes; ++lane) {
    const Vec3* c = corners.data() + 3 * faces[lane < n ? lane : 0];
    const Vec3 area = (c[1] - c[0]).cross(c[2] - c[0]), normal = area.normalized();
    const double charge = lane < n ? mesh_->polarization().dot(normal) / (4.0 * pi) : 0.0;
    double* out = table + lane;
    const auto put = [&](double value) { *out = value, out += n_lanes; };
    const auto put3 = [&](const Vec3& v) { put(v[0]), put(v[1]), put(v[2]); };
    for (int k = 0; k < 3; ++k) put3(c[k]);
    put3(normal), put(area.norm()), put(charge);
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = c[k], b = c[(k + 1) % 3];
      put3(a), put3(b), put((b - a).norm());
      put3(charge * (b - a).normalized().cross(normal)), put3(charge * normal);
    }
    for (int i = 0; i < rule.n && lane < n; ++i) {
      const double u = 0.5 * (1.0 + rule.nodes[i]);
      for (int k = 0; k < rule.n; ++k) {
        const Vec3 x = c[0] + u * (c[1] - c[0]) + 0.5 * (1.0 + rule.nodes[k]) * u * (c[2] - c[1]);
        positions.insert(positions.end(), x.data(), x.data() + 3);
        charges.push_back(0.25 * rule.weights[i] * rule.weights[k] * u * charge * area.norm());
      }
    }
  }
  const std::size_t stride = expansion_.moments_size();
  expansion_.add_charges(positions.data(), charges.data(), static_cast<Index>(charges.size()), clusters_.back().centre,
                         moments_.data() + (clusters_.size() - 1) * stride);
}

// Parts the candidates of a ball in those far from it and the rest; the rest of a leaf are groups.
ExpandedMesh::Sorted ExpandedMesh::sorted(const Vec3& centre, double radius, const std::vector<Index>& candidates,
                                          bool leaf) const {
  Sorted result;
  std::vector<Index> open = candidates;
  for (std::size_t i = 0; i < open.size(); ++i) {
    const Cluster& cluster = clusters_[open[i]];
    const Vec3 arm = centre - cluster.centre;
    const double sum = radius + cluster.radius;
    if (sum * sum < opening_ * opening_ * arm.squaredNorm()) {
      const double* moments = moments_.data() + static_cast<std::size_t>(open[i]) * expansion_.moments_size();
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

// A cube is a leaf where few groups are near, or where it is smaller than they are: on a surface of 1,800 faces cubes of half
// the size make evaluation a fifth faster and take four times the time to set up and the memory.
void ExpandedMesh::divide(Index cube, const std::vector<Index>& candidates, const std::vector<double>& inherited) {
  const Vec3 centre = cubes_[cube].centre;
  const double radius = std::sqrt(3.0) * cubes_[cube].half;
  std::vector<double> local = inherited;
  const auto add = [&](const Sorted& parts) {
    if (!parts.far.empty()) expansion_.add_far(parts.far.data(), static_cast<Index>(parts.far.size()), local.data());
    expansion_.complete(local.data());
  };
  const Sorted whole = sorted(centre, radius, candidates, true);
  double size = 0.0;
  for (const Index group : whole.near) size += group_radii_[group];
  if (static_cast<Index>(whole.near.size()) <= few_groups || radius * whole.near.size() < 0.6 * size) {
    add(whole);
    Cube& leaf = cubes_[cube];
    leaf.local = static_cast<Index>(locals_.size() / expansion_.local_size());
    locals_.insert(locals_.end(), local.begin(), local.end());
    leaf.begin = static_cast<Index>(nearest_.size());
    nearest_.insert(nearest_.end(), whole.near.begin(), whole.near.end());
    leaf.end = static_cast<Index>(nearest_.size());
    leaf.place = place_of(leaf);
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

ExpandedMesh::Place ExpandedMesh::place_of(const Cube& cube) const {
  const double depth = mesh_->depth(cube.centre), radius = 1.000001 * std::sqrt(3.0) * cube.half;
  return depth > radius ? Place::inside : depth < -radius ? Place::outside : Place::cut;
}

Index ExpandedMesh::leaf_at(const Vec3& point) const {
  if (!(point.cwiseAbs().maxCoeff() < cubes_[0].half)) return -1;
  Index cube = 0;
  while (cubes_[cube].child >= 0) {
    const Vec3& c = cubes_[cube].centre;
    cube = cubes_[cube].child + (point[0] > c[0] ? 1 : 0) + (point[1] > c[1] ? 2 : 0) + (point[2] > c[2] ? 4 : 0);
  }
  return cube;
}

void ExpandedMesh::field_and_gradient_block(const double* points, Index n, Quantity quantity, double* field,
                                            double* gradient) const {
  const auto point = [&](Index i) { return Vec3(points[i], points[n + i], points[2 * n + i]); };
  Index leaves[points_per_block], order[points_per_block];
  std::iota(order, order + n, 0);
  for (Index i = 0; i < n; ++i) leaves[i] = leaf_at(point(i));
  std::sort(order, order + n, [&](Index a, Index b) { return std::pair(leaves[a], a) < std::pair(leaves[b], b); });
  for (Index begin = 0, end; begin < n; begin = end) {
    // At most eight points of one leaf.
    const Index leaf = leaves[order[begin]];
    for (end = begin + 1; end < n && end < begin + n_lanes && leaves[order[end]] == leaf;) ++end;
    alignas(64) double x[3 * n_lanes], b[3 * n_lanes], g[6 * n_lanes];
    for (int lane = 0; lane < n_lanes; ++lane)
      for (int c = 0; c < 3; ++c) x[c * n_lanes + lane] = points[c * n + order[std::min<Index>(begin + lane, end - 1)]];
    if (leaf < 0) {
      mesh_->multipoles().field_block(x, n_lanes, b);
      mesh_->multipoles().gradient_block(x, n_lanes, g);
    } else {
      expansion_.evaluate(locals_.data() + static_cast<std::size_t>(cubes_[leaf].local) * expansion_.local_size(),
                          cubes_[leaf].centre, x, n_lanes, b, g);
    }
    for (Index k = begin; k < end; ++k) {
      const Index i = order[k];
      double near[3] = {}, near_gradient[6] = {};
      if (leaf >= 0) {
        const Cube& cube = cubes_[leaf];
        const Vec3 at = point(i);
        group_kernel(groups_.data(), nearest_.data() + cube.begin, cube.end - cube.begin, radius(), at.data(), near,
                     near_gradient);
        if (quantity == Quantity::flux_density &&
            (cube.place == Place::inside || (cube.place == Place::cut && mesh_->depth(at) > 0.0)))
          for (int c = 0; c < 3; ++c) near[c] += mesh_->polarization()[c];
      }
      for (int c = 0; c < 3; ++c) field[c * n + i] = b[c * n_lanes + (k - begin)] + near[c];
      for (int c = 0; c < 6; ++c) gradient[c * n + i] = g[c * n_lanes + (k - begin)] + near_gradient[c];
    }
  }
}

void ExpandedMesh::field_block(const double* points, Index n, Quantity quantity, double* field) const {
  double gradient[6 * points_per_block];
  field_and_gradient_block(points, n, quantity, field, gradient);
}

void ExpandedMesh::gradient_block(const double* points, Index n, double* gradient) const {
  double field[3 * points_per_block];
  field_and_gradient_block(points, n, Quantity::mu0_field_strength, field, gradient);
}

}  // namespace loomstone
