// Kicks of bodies that press on each other.
//
// The wrenches at the end of a sub-step differ from those at its start, and half of the difference
// acts at the end (kick_drift_kick.h), where no contacts act. If magnets that press on each other
// turn together, their wrenches and contact forces turn with them. The difference would then brake
// them. In a group of such bodies, the wrenches at the start therefore turn with the group before
// the difference is taken.
//
// Magnets and coils on obstacles or on bodies in bearings pull the group, too, and their forces do
// not turn with it. In scenes with such magnets or coils, all bodies keep the plain difference.
//
// A group receives a rigid motion in addition, unless it presses on an obstacle or on a body in a
// bearing. This motion makes the linear and angular momenta of the group change as much as those of
// bodies without contacts. RigidWorld alone would change the angular momentum, because it moves
// overlapping bodies apart and applies the impulses of a contact to points of the two bodies that
// differ by the gap.
#pragma once

#include "core/electrodynamics/kick_drift_kick.h"

namespace loomstone {

// A sub-step whose kicks are complete.
struct KickedSubstep {
  double h;                               // [s]
  const RigidState& start;                // bodies at the start
  const CarrierWrenches &first, &second;  // wrenches at the start and end
  const ContactAnswer& answer;
};
// Sets the velocities and angular momenta of the bodies in PressedGroups to those after the kicks.
// Does nothing if an obstacle or a body in a bearing carries a magnet or coil.
void share_kicks(const MagneticModel& model, const KickedSubstep& substep, MovingBodies& bodies);

}  // namespace loomstone
