#include "core/magnetics/forces/panel_wrench.h"

#include <algorithm>

#include "core/base/simd.h"
#include "core/magnetics/fast_sums/panel_clusters.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

// Adds to `sum` the force and torque that `field` exerts on a charge at `position`. All vectors are
// in the axes of the body with the charge.
void add_force(const Vec3& position, double charge, const Vec3& field, Wrench& sum) {
  const Vec3 force = charge * field;
  sum.force += force;
  sum.torque += position.cross(force);
}

// Forces and torques that the clusters of one grid (`by`) exert on those of a grid of another body
// (`on`). The charges mu0 sigma [T] are in the order of the clusters. For each set of charges on
// `on`, `sums` contains the contribution of these two grids to the wrench, in the axes of `on` and
// multiplied by mu0 and GridPair::share.
struct GridWrenches {
  const PanelClusters &on, &by;
  const RigidPose& pose;  // pose of `on` in the axes of `by`
  std::vector<Vector> on_charges;
  Vector by_charges;
  std::vector<Wrench> sums;

  void add_far(const ClusterPairs& pairs) {
    const std::vector<Points> fields =
        far_fields(Team{}, pairs, on, pose, by, by.node_charges(by_charges));
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const std::vector<Vector> charges = on.node_charges(on_charges[k]);
      for (std::size_t c = 0; c < charges.size(); ++c) {
        const Points& nodes = on.clusters()[c].nodes;
        for (Eigen::Index i = 0; i < nodes.rows(); ++i)
          add_force(nodes.row(i).transpose(), charges[c][i], fields[c].row(i).transpose(), sums[k]);
      }
    }
  }

  // Adds the forces and torques that the leaves `near` of `by` exert on the panels of the leaf `to`
  // of `on`.
  void add_near(const PanelCluster& to, const std::vector<Index>& near) {
    const PanelSet& set = on.panels();
    const Mat3 rotation = rotation_matrix(pose.orientation);
    const Index first = to.begin * set.per_panel, n = (to.end - to.begin) * set.per_panel;
    const Index padded = (n + n_lanes - 1) / n_lanes * n_lanes;
    using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;
    Columns x(padded, 3), field(padded, 3), whole = Columns::Zero(padded, 3);
    for (Index i = 0; i < padded; ++i) {
      const Vec3 local = set.samples.row(first + std::min(i, n - 1)).transpose();
      x.row(i) = (pose.position + rotation * local).transpose();
    }
    for (const Index b : near) {
      const PanelCluster& from = by.clusters()[b];
      panel_field({by.panels(), from.begin, from.end}, by_charges.data() + from.begin, x.data(),
                  padded, field.data());
      whole += field;
    }
    for (Index i = 0; i < n; ++i) {
      const Index sample = first + i, panel = sample / set.per_panel;
      const double area = set.panels[panel].area * set.shares[sample];
      const Vec3 local = rotation.transpose() * whole.row(i).transpose();
      for (std::size_t k = 0; k < sums.size(); ++k)
        add_force(set.samples.row(sample).transpose(), on_charges[k][panel] * area, local, sums[k]);
    }
  }
};

}  // namespace

std::optional<PlacedCharges> mean_charges(const MagneticBody& body) {
  const SourcePtr means = body.source->panel_means();
  const ChargedPanels* panels = (means ? means : body.source)->charged_panels();
  if (!panels) return std::nullopt;
  return PlacedCharges{panels->set(), panels->uniform_charges(), body.pose};
}

std::vector<Wrench> panel_wrenches(const PanelSet& on, const RigidPose& pose,
                                   const std::vector<Vector>& charges, const PlacedCharges& by) {
  const RigidPose from_by = relative_pose(pose, by.pose);
  const Mat3 to_world = rotation_matrix(pose.orientation);
  std::vector<Wrench> totals(charges.size());
  for (const GridPair& grids : interacting_grids(on, by.set)) {
    const PanelClusters mine(on, grids.one), other(by.set, grids.other);
    const ClusterPairs pairs(mine, from_by, other);
    GridWrenches grid{mine, other, from_by, {}, other.gathered(by.charges), {}};
    for (const Vector& each : charges) grid.on_charges.push_back(mine.gathered(each));
    grid.sums.resize(charges.size());
    grid.add_far(pairs);
    for (std::size_t c = 0; c < pairs.near.size(); ++c)
      if (!pairs.near[c].empty()) grid.add_near(mine.clusters()[c], pairs.near[c]);
    for (std::size_t k = 0; k < totals.size(); ++k) {
      totals[k].force += to_world * grid.sums[k].force / (mu0 * grids.share);
      totals[k].torque += to_world * grid.sums[k].torque / (mu0 * grids.share);
    }
  }
  return totals;
}

Wrench panel_wrench(const PlacedCharges& on, const PlacedCharges& by) {
  return panel_wrenches(on.set, on.pose, {on.charges}, by)[0];
}

}  // namespace loomstone
