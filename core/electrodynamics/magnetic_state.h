// State of magnets and currents, in addition to that of the bodies.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Currents and stored energy of the circuits. The other energies are totals since the start of the
// simulation.
struct CircuitState {
  Vector currents;      // (coils) current of each coil in a circuit; 0 for other coils [A]
  double energy = 0.0;  // energy stored in self and mutual inductances [J]
  // Energy dissipated in resistances [J]. It includes the energy that counts as heat in circuits
  // with tau R > 2 L; see kick.h.
  double heat = 0.0;
  // Energy supplied by the sources of voltages and given currents, and by scripted obstacles that
  // move against the forces of currents [J].
  double supply = 0.0;
  double bearings = 0.0;  // energy that bearings take from bodies; < 0 if bearings drive bodies [J]
};

struct MagneticState {
  CircuitState circuits;
  Points moments;  // (dipoles x 3) induced moments [A m^2]; initial guess in the next step
};

}  // namespace loomstone
