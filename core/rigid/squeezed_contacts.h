// Contacts of bodies that obstacles squeeze between them.
#pragma once

#include <vector>

#include "core/rigid/bullet.h"

namespace loomstone {

// The contact rows of Bullet's solver, and the bodies to which they refer.
struct ContactRows {
  btConstraintArray& rows;
  const btAlignedObjectArray<btSolverBody>& bodies;
};

// If obstacles are closer together than bodies between them are wide, no translation of the bodies
// resolves all overlaps. Bullet would move the bodies to and fro, and friction would not hold them.
// This function lets an overlap move a body only until it equals the overlap on the opposite side
// of the body. It returns for each row the impulse with which the obstacles squeeze the bodies in a
// step of length `step` [s], as if each contact were a spring [N s]. The impulse is 0 for contacts
// that squeeze no body, for overlaps that are only rounding, and for overlaps so deep that a body
// has partly passed a surface. The solver adds the impulse to the normal impulse that bounds
// friction. It does not apply the impulse itself, which opposite contacts would balance.
std::vector<btScalar> relieve_squeezed(const ContactRows& contacts, btScalar step);

}  // namespace loomstone
