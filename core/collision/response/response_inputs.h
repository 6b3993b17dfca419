// The start of a step, as input to contact terms and to corrections of the motion.
#pragma once

#include "core/base/types.h"
#include "core/collision/tangle/tangle.h"

namespace loomstone {

// For terms of the implicit solve; arrays have a row for each collision vertex.
struct ContactInputs {
  const Points& x0;  // (n x 3) [m]
  const Points& v0;  // (n x 3) velocities; those of prescribed vertices go into the drift [m/s]
  const Points& last_change;   // (n x 3) of velocities in the last step, 0 where unknown [m/s]
  const Points& body_centres;  // (b x 3) [m]
  double step;                 // h [s]
  Index n_cloth;               // cloth vertices; rows of bodies follow theirs
};

// For corrections of the motion x0 -> x1.
struct MotionInputs {
  const Points& x0;            // (n x 3) [m]
  const Vector& inverse_mass;  // (n) of cloth vertices, 0 for prescribed vertices [1/kg]
  const Tangle& tangle;        // what intersects at x0
};

}  // namespace loomstone
