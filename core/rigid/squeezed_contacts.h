// Contacts of bodies that obstacles squeeze from opposite sides.
#pragma once

#include <vector>

#include "core/rigid/bullet.h"

namespace loomstone {

// The contact rows of Bullet's solver, and the bodies to which they refer.
struct ContactRows {
  btConstraintArray& rows;
  const btAlignedObjectArray<btSolverBody>& bodies;
};

// If the distance between two obstacles is less than the width of a body between them, no motion of
// the body resolves its overlaps with both. Bullet would move the body to and fro, and friction
// would not hold it. This function lets the deeper overlap move the body only until both are equal.
// It returns for each row the impulse with which the obstacles squeeze the body in a step of length
// `step` [s], as if the body were elastic [N s]. The impulse is 0 for other contacts and for
// overlaps that are only rounding. The impulses of the two sides cancel, so they only add to the
// normal impulse that bounds friction.
std::vector<btScalar> relieve_squeezed(const ContactRows& contacts, btScalar step);

}  // namespace loomstone
