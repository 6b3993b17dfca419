// A kick by coils and bearings: wrenches on bodies, and the currents of circuits.
//
// A coil with current i feels i G and its partners -i G by balance of momentum, where G is the
// force per ampere; the same G times the velocities is its back-EMF, so that what a circuit loses
// the bodies gain, to the last bit of a kick: of length tau, at rest positions, with middle values
// (subscript m), L (i' - i) = tau (V - R i_m - G v_m), m (v' - v) = tau (F + G i_m). With several
// circuits L is the matrix of their own and mutual inductances, to which M di/dt of the given
// currents is added, and G of each contains the currents of the others: what they do to one another
// in a kick is taken at i_m, by iteration, and half of it is stored in L as bodies move. The same
// holds for what a circuit does to itself by bodies that it magnetises (circuit_response.h), whose
// flux adds to L. What moves by script has its velocities in G v too; it feels nothing, and its
// work counts as supply.
#pragma once

#include <vector>

#include "core/electrodynamics/coil_forces.h"
#include "core/electrodynamics/inductances.h"
#include "core/electrodynamics/magnetic_model.h"
#include "core/electrodynamics/magnetic_state.h"

namespace loomstone {

// All that acts where carriers are at one instant.
struct Actions {
  CarrierWrenches magnets;     // what magnets do to one another, without currents of circuits
  CarrierWrenches magnetised;  // of that, what follows from bodies that coils of given currents
                               // magnetise, or empty; its work is that of the currents' sources
  CoilForces coils;
  Inductances inductances;
};

// The start of a kick.
struct KickStart {
  double time = 0.0, duration = 0.0;  // of its middle [s]; [s]
  const RigidState& bodies;
  const Points& momenta;             // angular, of bodies, world axes [kg m^2/s]
  const std::vector<Twist>& twists;  // of obstacles
  const Actions& actions;
};

// Wrenches on bodies within a kick; advances the circuits by it.
CarrierWrenches kick_wrenches(const MagneticModel& model, const KickStart& start,
                              CircuitState& circuits);

}  // namespace loomstone
