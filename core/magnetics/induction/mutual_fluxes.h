// Fluxes of the charge on one body through the panels of another, for each pair of grids that
// interacting_grids() returns. Each pair of near clusters has a stored matrix. Far clusters
// interact through their nodes; see panel_clusters.h.
#pragma once

#include <memory>
#include <vector>

#include "core/magnetics/fast_sums/panel_clusters.h"

namespace loomstone {

class MutualFluxes {
 public:
  // `pose` is the pose of `on` in the axes of `by`.
  MutualFluxes(const Team& team, const PanelSet& on, const RigidPose& pose, const PanelSet& by);
  // Adds to `fluxes` [T m^2] the flux through each panel of `on`, due to the charges on the grid of
  // `by` that interacts with the panel's grid. `charges` contains mu0 sigma [T] times
  // PanelGrid::share. The flux is divided by GridPair::share.
  void add(const Team& team, const Vector& charges, Vector& fluxes) const;

 private:
  struct Part {
    double share;
    std::unique_ptr<const PanelClusters> on, by;
    std::unique_ptr<const ClusterPairs> pairs;
    // near[c][k]: matrix of leaf c of `on` and leaf pairs->near[c][k] of `by` [m^2]
    std::vector<std::vector<FluxMatrix>> near;
  };
  RigidPose pose_;
  std::vector<Part> parts_;
};

}  // namespace loomstone
