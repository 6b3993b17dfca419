// State at the start of a step, as input to contact terms and to corrections of the motion.
#pragma once

#include "core/base/types.h"
#include "core/collision/tangle/tangle.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

// Inputs for terms of the implicit solve, with n collision vertices and b bodies.
struct ContactInputs {
  const Points& x0;           // (n x 3) [m]
  const Points& v0;           // (n x 3) velocities [m/s]; those of obstacles enter ExtraTerm::drift
  const Points& last_change;  // (n x 3) last velocity change, scaled to `step`; 0 if unknown [m/s]
  const Points& body_centres;  // (b x 3) centres of mass [m]
  double step;                 // h [s]
  Index n_cloth;               // number of cloth vertices; rows of bodies follow
  const Vector& inverse_mass;  // (n) inverse masses of free cloth vertices, else 0 [1/kg]
  // (n_cloth x 3) elastic and external forces on cloth at the start [N]; 0 rows if they are not
  // known
  const Points& forces;
  // Rows of the solve for which terms are made. Contacts that act on none of them have no term.
  IndexRange rows = all_indices;
};

// Inputs for corrections of the motion x0 -> x1.
struct MotionInputs {
  const Points& x0;  // (n x 3) [m]
  // (n) Inverse masses of free cloth vertices and, in certification, of free bodies; else 0 [1/kg].
  const Vector& inverse_mass;
  const Tangle& tangle;  // intersections at x0
};

}  // namespace loomstone
