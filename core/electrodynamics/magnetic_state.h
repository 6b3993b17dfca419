// State of magnets and currents, in addition to that of the bodies.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Currents of the circuits, and their energy balance since the start.
struct CircuitState {
  Vector currents;        // (coils) currents of circuits, 0 for other coils [A]
  double energy = 0.0;    // energy stored in self and mutual inductances [J]
  double heat = 0.0;      // energy dissipated in resistances [J]
  double supply = 0.0;    // energy delivered by sources, including those of given currents [J]
  double bearings = 0.0;  // energy that bearings remove; < 0 if they drive [J]
};

struct MagneticState {
  CircuitState circuits;
  Points moments;  // (k x 3) induced dipole moments; initial guess in the next step [A m^2]
};

}  // namespace loomstone
