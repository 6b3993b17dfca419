// The normal field that others apply to the panels of a body, at points dense enough for integrals
// of it: panels are halved where it varies too much within them, as beneath the edges of a pole
// that touches.
#pragma once

#include <cstdint>
#include <vector>

#include "core/magnetics/sources/body.h"
#include "core/magnetics/sources/flat_panels.h"

namespace loomstone {

struct PanelSet;

struct AppliedField {
  static constexpr int points = 9;  // of each panel and leaf
  // Part of a panel that was halved, and halved again.
  struct Leaf {
    FlatPanel panel;
    Index parent = 0;
    Vec3 positions[points];                // [m]
    double areas[points], normal[points];  // [m^2], B.n [T]
  };
  Vector normal;                     // B.n at the samples of the set [T]
  std::vector<Leaf> leaves;          // of panels that were halved
  std::vector<std::uint8_t> halved;  // 1: leaves stand for the panel
  Vector fluxes;                     // through each panel [T m^2]
};

// B of `by` and a uniform one [T], world axes, on a body at a pose.
struct AppliedSources {
  const RigidPose& pose;
  const std::vector<MagneticBody>& by;
  const Vec3& uniform;
};

// Leaves are halved until the estimated error of the integral of (B.n) B is below `tolerance` times
// that of (B.n)^2.
AppliedField applied_field(const Team& team, const PanelSet& set, const AppliedSources& sources,
                           double tolerance);

}  // namespace loomstone
