// Forces and torques between two bodies with N uniformly charged panels, in O(N log N) time. The
// field of one body is evaluated at the other: at its sample points for near panels, and at the
// nodes of its clusters for far clusters; see panel_clusters.h. If each grid of one body interacts
// only with the corresponding grid of the other (interacting_grids()), Richardson extrapolation is
// applied to force and torque.
#pragma once

#include <optional>
#include <vector>

#include "core/magnetics/forces/interaction.h"
#include "core/magnetics/sources/charged_panels.h"

namespace loomstone {

// Charged panels at a pose. The charges mu0 sigma [T] are already multiplied by PanelGrid::share.
struct PlacedCharges {
  const PanelSet& set;
  const Vector& charges;
  const RigidPose& pose;
};

// Returns the panels of a body with the mean charge of each, for forces between induced bodies.
// Returns nullopt for sources without charged panels. The variation of charge within panels is
// omitted, because the field of the varying charge is expensive to evaluate.
std::optional<PlacedCharges> mean_charges(const MagneticBody& body);

// panel_wrench() returns the wrench that `by` exerts on `on`. panel_wrenches() returns the wrench
// that `by` exerts on the panels `on` at `pose`, for each set of charges on these panels. Errors
// are not estimated: Wrench::error is 0.
Wrench panel_wrench(const PlacedCharges& on, const PlacedCharges& by);
std::vector<Wrench> panel_wrenches(const PanelSet& on, const RigidPose& pose,
                                   const std::vector<Vector>& charges, const PlacedCharges& by);

}  // namespace loomstone
