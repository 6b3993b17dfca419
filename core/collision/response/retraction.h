// Moves two surfaces apart, each as a whole, if a large part of one has passed through the other.
#pragma once

#include "core/collision/model/collision_model.h"
#include "core/collision/tangle/tangle.h"

namespace loomstone {

// Motion of surfaces that are retracted. The two surfaces of a retraction accelerate like rigid
// bodies under equal and opposite forces at one point, so momentum and angular momentum are
// conserved if both accelerate. Bodies, obstacles and cloths with prescribed vertices do not
// accelerate. Both arrays have 0 rows if the tangle has no retractions.
struct RetractedMotion {
  Points acceleration{0, 3};  // (n x 3) acceleration of each vertex [m/s^2]
  // (n x 3) Velocity of each vertex [m/s]. For a vertex of one of the two surfaces of a retraction,
  // it is the velocity that the vertex would have at the end of the step if the surface were rigid
  // or, if the surface does not accelerate, the mean velocity of the surface. For all other
  // vertices, and if neither of the two surfaces accelerates, it is the given velocity.
  Points velocity{0, 3};
};

// Computes the motion from the positions x (n x 3) [m] at the start of the step and the velocities
// `velocity` (n x 3) [m/s] without retraction: ContactInputs::v0, or the mean velocities of a
// motion that is to be corrected. `inverse_mass` (n) [1/kg] is 0 for prescribed vertices. `step` is
// the length of the step [s].
RetractedMotion retracted_motion(const CollisionModel& model, const Tangle& tangle,
                                 const Vector& inverse_mass, const Points& x,
                                 const Points& velocity, double step);

}  // namespace loomstone
