// A kick computes the wrenches on bodies, including those of coils and bearings, and advances the
// circuit currents.
//
// Let G be the force per ampere on a coil. At the current i, the coil feels the force i G. By
// conservation of momentum, the magnets and other coils that exert this force together feel -i G.
// The back-EMF is G times the velocity v. Up to rounding, bodies therefore gain the energy that the
// back-EMF takes from a circuit. Positions are constant in a kick. A kick of duration tau solves
//   L (i' - i) = tau (V - R i_m - G v_m),   m (v' - v) = tau (F + G i_m)
// for the new values i' and v'. The subscript m denotes the mean of the old and new values; without
// inductance, i' is i_m. In a circuit with tau R > 2 L, i_m is i' instead of the mean, because i'
// would otherwise oscillate about the slowly varying current V / R. The energy L (i' - i)^2 / 2
// then counts as heat. L is the inductance, R the resistance, V the source voltage, m the mass, and
// F the force without circuits.
//
// Let w and w' be the angular velocities of a body in a bearing at the start and at the end of the
// kick, and I its moment of inertia about the axis. Friction acts at the mean of w and w' or, if
// tau times the friction coefficient exceeds 2 I, at w'. In the second case, the bearing also takes
// the energy I (w' - w)^2 / 2.
//
// With several circuits, L is the matrix of self and mutual inductances. The mutual inductances M
// with coils of given current i_g add the EMF -M di_g/dt. The G of a circuit depends on the
// currents of the other circuits and is evaluated at their i_m, by iteration. The circuits lose
// energy to the part of the back-EMF that depends on these currents. Half of this energy does work
// on bodies, and half is stored in L as the bodies move. The same holds for the action of a circuit
// on itself through bodies that it magnetises (circuit_response.h). The flux of these bodies adds
// to L. The velocities of scripted obstacles also enter G v. Forces do not move these obstacles.
// The work that obstacles do against the forces of currents counts as supply.
#pragma once

#include <vector>

#include "core/electrodynamics/coil_forces.h"
#include "core/electrodynamics/inductances.h"
#include "core/electrodynamics/magnetic_model.h"
#include "core/electrodynamics/magnetic_state.h"

namespace loomstone {

// Magnetic actions on the carriers at one instant.
struct Actions {
  // Wrenches of the magnets on each other and of the uniform field on the magnets. Induced magnets
  // have the moments that they would have without circuit currents.
  CarrierWrenches magnets;
  // Part of `magnets` that is due to magnetisation by given currents; empty if given currents
  // magnetise no bodies. The sources of these currents supply the work of this part.
  CarrierWrenches magnetised;
  CoilForces coils;
  Inductances inductances;
};

// Midpoint and length of a kick, and the state and magnetic actions at its start.
struct KickStart {
  double time = 0.0, duration = 0.0;  // midpoint and length of the kick [s]
  const RigidState& bodies;
  const Points& momenta;             // angular momenta of bodies, world axes [kg m^2/s]
  const std::vector<Twist>& twists;  // motion of the obstacles
  const Actions& actions;
};

// Returns the wrenches on all carriers in a kick and advances the circuits by the kick.
CarrierWrenches kick_wrenches(const MagneticModel& model, const KickStart& start,
                              CircuitState& circuits);

}  // namespace loomstone
