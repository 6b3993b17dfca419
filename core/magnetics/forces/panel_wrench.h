// Forces between two bodies with uniformly charged panels, in N log N time. Near panels act at the
// samples of the other body, and far clusters at their nodes; see panel_clusters.h. Richardson
// extrapolation applies to the force of bodies that interact grid by grid.
#pragma once

#include <optional>
#include <vector>

#include "core/magnetics/forces/interaction.h"
#include "core/magnetics/sources/charged_panels.h"

namespace loomstone {

// Panels at a pose, with charges mu0 sigma [T] that include the shares of their grids.
struct PlacedCharges {
  const PanelSet& set;
  const Vector& charges;
  const RigidPose& pose;
};

// Returns the mean charges of the panels of an induced body, for forces between induced bodies. The
// part that varies within panels responds only to magnets, and its field is expensive. There is no
// value for sources without panels.
std::optional<PlacedCharges> mean_charges(const MagneticBody& body);

// panel_wrench() returns the wrench on `on`. panel_wrenches() returns one wrench for each set of
// charges on the panels `on`. Neither estimates Wrench::error, which is 0.
Wrench panel_wrench(const PlacedCharges& on, const PlacedCharges& by);
std::vector<Wrench> panel_wrenches(const PanelSet& on, const RigidPose& pose,
                                   const std::vector<Vector>& charges, const PlacedCharges& by);

}  // namespace loomstone
