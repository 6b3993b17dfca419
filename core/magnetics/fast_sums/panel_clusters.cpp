#include "core/magnetics/fast_sums/panel_clusters.h"

#include <algorithm>
#include <cmath>

#include "core/magnetics/fast_sums/point_tree.h"
#include "core/magnetics/sources/panel_kernels.h"

namespace loomstone {

namespace {

// A cluster has `n_nodes` nodes in each direction in which its bounding box is not flat. Two
// clusters are far apart only if the sum of their radii is at most `opening` times the distance
// between their centres. With these values, the relative error due to clusters is less than 3e-6 in
// fluxes and less than 1e-6 in forces (docs/experiments/magnetics.md).
constexpr int n_nodes = 6;
constexpr double opening = 0.5;
constexpr int points_a_direction = 3;  // number of sample points in each direction of a panel
constexpr Index leaf_panels = 32;
// Clusters that are far apart interact by nodes if there are at most this many pairs of nodes per
// pair of panels. A pair of nodes is evaluated in every iteration of GMRES. A pair of panels costs
// more, but is evaluated only once.
constexpr double most_node_pairs = 2.5;

// Chebyshev nodes in an interval, or one node if the interval has no length.
struct Nodes {
  std::vector<double> at, weights;  // positions [m], and barycentric weights [BerrutTrefethen2004]

  Nodes(double low, double high, double size) {
    constexpr double flat = 1e-9;  // largest length that counts as zero, in units of `size`
    const int n = high - low > flat * size ? n_nodes : 1;
    for (int k = 0; k < n; ++k) {
      const double angle = (2 * k + 1) * pi / (2 * n);
      at.push_back(0.5 * (low + high) + 0.5 * (high - low) * std::cos(angle));
      weights.push_back(k % 2 == 0 ? std::sin(angle) : -std::sin(angle));
    }
  }
  // Returns the values of the Lagrange polynomials at x.
  std::vector<double> lagrange(double x) const {
    std::vector<double> values(at.size(), 0.0);
    double sum = 0.0;
    for (std::size_t k = 0; k < at.size(); ++k) {
      if (x == at[k]) {
        std::fill(values.begin(), values.end(), 0.0);
        values[k] = 1.0;
        return values;
      }
      values[k] = weights[k] / (x - at[k]);
      sum += values[k];
    }
    for (double& value : values) value /= sum;
    return values;
  }
};

struct BoxNodes {
  Nodes axes[3];
  BoxNodes(const Vec3& low, const Vec3& high, double size)
      : axes{{low[0], high[0], size}, {low[1], high[1], size}, {low[2], high[2], size}} {}
  Points positions() const {
    Points x(axes[0].at.size() * axes[1].at.size() * axes[2].at.size(), 3);
    Eigen::Index row = 0;
    for (const double a : axes[0].at)
      for (const double b : axes[1].at)
        for (const double c : axes[2].at) x.row(row++) << a, b, c;
    return x;
  }
  Eigen::RowVectorXd lagrange(const Vec3& x) const {
    const std::vector<double> values[3] = {axes[0].lagrange(x[0]), axes[1].lagrange(x[1]),
                                           axes[2].lagrange(x[2])};
    Eigen::RowVectorXd products(values[0].size() * values[1].size() * values[2].size());
    Eigen::Index at = 0;
    for (const double a : values[0])
      for (const double b : values[1])
        for (const double c : values[2]) products[at++] = a * b * c;
    return products;
  }
};

// Returns the index of the side of a body on which a panel lies: twice the index of the axis
// closest to the panel's normal, plus one if the normal has a negative component along this axis.
int side_of(const FlatPanel& panel) {
  int axis;
  panel.normal.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (panel.normal[axis] < 0.0 ? 1 : 0);
}

}  // namespace

PanelClusters::PanelClusters(const PanelSet& set, const PanelGrid& grid) : panels_({}, 1) {
  std::vector<Index> sides[6];
  for (Index i = grid.begin; i < grid.end; ++i) sides[side_of(set.panels[i])].push_back(i);
  for (const std::vector<Index>& side : sides) {
    if (side.empty()) continue;
    Points centres(side.size(), 3);
    for (std::size_t k = 0; k < side.size(); ++k)
      centres.row(k) = set.panels[side[k]].centre.transpose();
    const PointTree tree = make_point_tree(centres, leaf_panels);
    const auto first = static_cast<Index>(clusters_.size()),
               row = static_cast<Index>(order_.size());
    roots_.push_back(first);
    for (const Index k : tree.order) order_.push_back(side[k]);
    for (const PointCell& cell : tree.cells) {
      PanelCluster& cluster = clusters_.emplace_back();
      cluster.begin = row + cell.begin;
      cluster.end = row + cell.end;
      for (int c = 0; c < 2; ++c)
        if (!cell.leaf()) cluster.children[c] = first + cell.children[c];
    }
  }
  std::vector<FlatPanel> ordered;
  for (const Index i : order_) ordered.push_back(set.panels[i]);
  panels_ = PanelSet(std::move(ordered), points_a_direction);
  for (auto cluster = clusters_.rbegin(); cluster != clusters_.rend(); ++cluster)
    add_nodes(*cluster);
}

// Sets the centre, radius, reach, nodes and weights of a cluster. Its children must already have
// nodes.
void PanelClusters::add_nodes(PanelCluster& cluster) const {
  Vec3 low = panels_.panels[cluster.begin].centre, high = low;
  for (Index i = cluster.begin; i < cluster.end; ++i) {
    const FlatPanel& panel = panels_.panels[i];
    cluster.reach = std::max(cluster.reach, panel.reach);
    for (int k = 0; k < panel.corners; ++k) {
      low = low.cwiseMin(panel.corner[k]);
      high = high.cwiseMax(panel.corner[k]);
    }
  }
  cluster.centre = 0.5 * (low + high);
  cluster.radius = 0.5 * (high - low).norm();
  const BoxNodes box(low, high, panels_.radius);
  cluster.nodes = box.positions();
  if (cluster.leaf()) {
    cluster.weights.setZero(cluster.end - cluster.begin, cluster.nodes.rows());
    for (Index i = cluster.begin; i < cluster.end; ++i)
      for (Index k = i * panels_.per_panel; k < (i + 1) * panels_.per_panel; ++k)
        cluster.weights.row(i - cluster.begin) += panels_.shares[k] * panels_.panels[i].area *
                                                  box.lagrange(panels_.samples.row(k).transpose());
    return;
  }
  const Points &one = clusters_[cluster.children[0]].nodes,
               &other = clusters_[cluster.children[1]].nodes;
  cluster.weights.resize(one.rows() + other.rows(), cluster.nodes.rows());
  for (Eigen::Index k = 0; k < one.rows(); ++k)
    cluster.weights.row(k) = box.lagrange(one.row(k).transpose());
  for (Eigen::Index k = 0; k < other.rows(); ++k)
    cluster.weights.row(one.rows() + k) = box.lagrange(other.row(k).transpose());
}

Vector PanelClusters::gathered(const Vector& all) const {
  Vector own(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) own[i] = all[order_[i]];
  return own;
}

void PanelClusters::scatter(const Vector& own, double factor, Vector& all) const {
  for (std::size_t i = 0; i < order_.size(); ++i) all[order_[i]] += factor * own[i];
}

std::vector<Vector> PanelClusters::node_charges(const Vector& densities) const {
  std::vector<Vector> charges(clusters_.size());
  for (std::size_t c = clusters_.size(); c-- > 0;) {
    const PanelCluster& cluster = clusters_[c];
    if (cluster.leaf()) {
      charges[c] = cluster.weights.transpose() *
                   densities.segment(cluster.begin, cluster.end - cluster.begin);
      continue;
    }
    const Vector &one = charges[cluster.children[0]], &other = charges[cluster.children[1]];
    charges[c] = cluster.weights.topRows(one.size()).transpose() * one +
                 cluster.weights.bottomRows(other.size()).transpose() * other;
  }
  return charges;
}

Vector PanelClusters::fluxes(std::vector<Points> fields) const {
  Vector result(order_.size());
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    const PanelCluster& cluster = clusters_[c];
    const Points inner = cluster.weights * fields[c];
    if (cluster.leaf()) {
      for (Index i = cluster.begin; i < cluster.end; ++i)
        result[i] = inner.row(i - cluster.begin).dot(panels_.panels[i].normal);
      continue;
    }
    Points &one = fields[cluster.children[0]], &other = fields[cluster.children[1]];
    one += inner.topRows(one.rows());
    other += inner.bottomRows(other.rows());
  }
  return result;
}

std::vector<GridPair> interacting_grids(const PanelSet& one, const PanelSet& other) {
  constexpr double rounding = 1e-9;
  const auto alike = [](const PanelGrid& a, const PanelGrid& b) {
    return std::abs(a.share - b.share) <= rounding;
  };
  std::vector<GridPair> pairs;
  if (std::equal(one.grids.begin(), one.grids.end(), other.grids.begin(), other.grids.end(),
                 alike)) {
    for (std::size_t g = 0; g < one.grids.size(); ++g)
      pairs.push_back({one.grids[g], other.grids[g], one.grids[g].share});
  } else {
    pairs.push_back({{0, static_cast<Index>(one.panels.size()), 1.0},
                     {0, static_cast<Index>(other.panels.size()), 1.0},
                     1.0});
  }
  return pairs;
}

ClusterPairs::ClusterPairs(const PanelClusters& on, const RigidPose& pose, const PanelClusters& by)
    : far(on.clusters().size()), near(on.clusters().size()) {
  const Mat3 rotation = rotation_matrix(pose.orientation);
  std::vector<std::pair<Index, Index>> open;
  for (const Index a : on.roots())
    for (const Index b : by.roots()) open.emplace_back(a, b);
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    const PanelCluster &to = on.clusters()[a], &from = by.clusters()[b];
    const double distance = (pose.position + rotation * to.centre - from.centre).norm();
    const double panels = static_cast<double>(to.end - to.begin) * (from.end - from.begin);
    const double nodes = static_cast<double>(to.nodes.rows() * from.nodes.rows());
    // The second condition ensures that the panels of `from` are so far from `to` that direct
    // evaluation would replace them by point charges, too; see PanelSet::near.
    const bool apart = to.radius + from.radius <= opening * distance &&
                       PanelSet::near * from.reach <= distance - to.radius - from.radius;
    if (apart && nodes <= most_node_pairs * panels) {
      far[a].push_back(b);
    } else if (to.leaf() && from.leaf()) {
      near[a].push_back(b);
    } else if (from.leaf() || (!to.leaf() && to.radius >= from.radius)) {
      for (const Index child : to.children) open.emplace_back(child, b);
    } else {
      for (const Index child : from.children) open.emplace_back(a, child);
    }
  }
}

std::vector<Points> far_fields(const Team& team, const ClusterPairs& pairs, const PanelClusters& on,
                               const RigidPose& pose, const PanelClusters& by,
                               const std::vector<Vector>& charges) {
  using panel_kernels::add_smoothed_field;
  const Mat3 rotation = rotation_matrix(pose.orientation);
  // Columns: position (3) [m], mu0 times charge / (4 pi) [T m^2], and squared smoothing length,
  // which is 0.
  using Table = Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor>;
  std::vector<Table> tables(by.clusters().size());
  for (std::size_t c = 0; c < tables.size(); ++c) {
    tables[c].setZero(charges[c].size(), 5);
    tables[c].leftCols<3>() = by.clusters()[c].nodes;
    tables[c].col(3) = charges[c] / (4.0 * pi);
  }
  std::vector<Points> fields(on.clusters().size());
  parallel_tasks(team, static_cast<Index>(fields.size()), [&](Index c) {
    const Points& nodes = on.clusters()[c].nodes;
    const auto n = static_cast<Index>(nodes.rows()), padded = (n + n_lanes - 1) / n_lanes * n_lanes;
    Eigen::Matrix<double, Eigen::Dynamic, 3> x(padded, 3), field(padded, 3);
    for (Index i = 0; i < padded; ++i)
      x.row(i) = (pose.position + rotation * nodes.row(std::min(i, n - 1)).transpose()).transpose();
    field.setZero();
    for (const Index from : pairs.far[c])
      LOOMSTONE_WIDEST(add_smoothed_field)(tables[from].data(),
                                           static_cast<Index>(tables[from].rows()), x.data(),
                                           padded, field.data());
    fields[c] = field.topRows(n) * rotation;
  });
  return fields;
}

}  // namespace loomstone
