// Normal component of the applied field on the panels of a body, sampled at enough points to
// integrate the force on the body. Panels are bisected where the field varies too much within them,
// for example under the edges of a pole that touches the body.
#pragma once

#include <cstdint>
#include <vector>

#include "core/magnetics/sources/body.h"
#include "core/magnetics/sources/flat_panels.h"

namespace loomstone {

struct PanelSet;

struct AppliedField {
  static constexpr int points = 9;  // number of points on each panel and leaf
  // Part of a panel after one or more bisections.
  struct Leaf {
    FlatPanel panel;
    Index parent = 0;
    Vec3 positions[points];                // positions of the points [m]
    double areas[points], normal[points];  // area that each point represents [m^2], B.n there [T]
  };
  Vector normal;                     // B.n at the samples of the panels [T]
  std::vector<Leaf> leaves;          // parts of bisected panels
  std::vector<std::uint8_t> halved;  // 1 if leaves replace the panel
  Vector fluxes;                     // flux through each panel [T m^2]
};

// Sources of the applied field: the magnets and coils `by`, and a uniform flux density in world
// axes [T]. `pose` is the pose of the body that has the panels.
struct AppliedSources {
  const RigidPose& pose;
  const std::vector<MagneticBody>& by;
  const Vec3& uniform;
};

// Evaluates the applied field. Panels are bisected until the estimated error of the surface
// integral of (B.n) B is at most `tolerance` times the integral of (B.n)^2, or until there are at
// least 4,000 leaves.
AppliedField applied_field(const Team& team, const PanelSet& set, const AppliedSources& sources,
                           double tolerance);

}  // namespace loomstone
