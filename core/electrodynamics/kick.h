// A kick computes the wrenches on bodies, including those of coils and bearings, and advances the
// circuit currents.
//
// Let G be the force per ampere on a coil. With current i the coil feels i G, and its partners feel
// -i G by conservation of momentum. The back-EMF is the same G times the velocities, so bodies gain
// exactly the energy that a circuit loses, up to rounding. In a kick of duration tau positions are
// constant. With new values (prime) and midpoint values (subscript m),
//   L (i' - i) = tau (V - R i_m - G v_m),   m (v' - v) = tau (F + G i_m).
// With several circuits, L is the matrix of self and mutual inductances, and the EMF M di/dt of the
// given currents is added. The G of each circuit then depends on the currents of the others. The
// interaction of circuits in a kick is evaluated at i_m, by iteration. Half of its energy is stored
// in L as the bodies move. The same applies to the action of a circuit on itself through bodies
// that it magnetises (circuit_response.h). Their flux adds to L. The velocities of scripted
// obstacles also enter G v. These obstacles feel no force, and their work counts as supply.
#pragma once

#include <vector>

#include "core/electrodynamics/coil_forces.h"
#include "core/electrodynamics/inductances.h"
#include "core/electrodynamics/magnetic_model.h"
#include "core/electrodynamics/magnetic_state.h"

namespace loomstone {

// All actions on the carriers at one instant.
struct Actions {
  CarrierWrenches magnets;  // wrenches among magnets, without circuit currents
  // Part of `magnets` that is due to magnetisation by given currents, or empty. Its work is done by
  // the sources of these currents.
  CarrierWrenches magnetised;
  CoilForces coils;
  Inductances inductances;
};

// Start of a kick.
struct KickStart {
  double time = 0.0, duration = 0.0;  // midpoint and length of the kick [s]
  const RigidState& bodies;
  const Points& momenta;             // angular momenta of bodies, world axes [kg m^2/s]
  const std::vector<Twist>& twists;  // motion of the obstacles
  const Actions& actions;
};

// Returns the wrenches on bodies in a kick and advances the circuits by the kick.
CarrierWrenches kick_wrenches(const MagneticModel& model, const KickStart& start,
                              CircuitState& circuits);

}  // namespace loomstone
