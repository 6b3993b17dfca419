// The state of magnets and currents, besides that of the bodies.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// The circuits of a scene, and the energy that has gone where since the start.
struct CircuitState {
  Vector currents;        // (coils) of those with a circuit, else 0 [A]
  double energy = 0.0;    // of their inductances, own and mutual [J]
  double heat = 0.0;      // in their resistances [J]
  double supply = 0.0;    // by sources, of given currents as well [J]
  double bearings = 0.0;  // taken out by bearings' friction and torque [J]
};

// State.
struct MagneticState {
  CircuitState circuits;
  Points moments;  // (k x 3) of spheres that are dipoles, where the next are sought [A m^2]
};

}  // namespace loomstone
