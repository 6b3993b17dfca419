// Moves surfaces apart as a whole where a large part of one has passed through the other.
#pragma once

#include "core/collision/model/collision_model.h"
#include "core/collision/tangle/tangle.h"

namespace loomstone {

// Motion of surfaces that are retracted. Two surfaces accelerate as rigid bodies do under equal and
// opposite forces at one point, so momentum and angular momentum of free cloth are conserved.
// Surfaces with prescribed vertices, bodies and obstacles do not accelerate. Both arrays have
// 0 rows if nothing is retracted.
struct RetractedMotion {
  Points acceleration{0, 3};  // (n x 3) of each vertex [m/s^2]
  // (n x 3) At the end of the step, as if the surfaces were rigid. Equal to the velocity at the
  // start for vertices of other surfaces [m/s].
  Points velocity{0, 3};
};

// `velocity` (n x 3) [m/s] and `inverse_mass` (n) [1/kg] belong to the start of the step, whose
// length is `step` [s].
RetractedMotion retracted_motion(const CollisionModel& model, const Tangle& tangle,
                                 const Vector& inverse_mass, const Points& x,
                                 const Points& velocity, double step);

}  // namespace loomstone
