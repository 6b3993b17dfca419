// Last check that fast bodies stay on their side of the surfaces of obstacles.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// Contacts ahead of the motion keep fast bodies from passing through surfaces. They are found for
// the velocities before the contacts act, so a body that another one strikes may move along a path
// without contacts. This function tests the path of the centre of a body, which has just moved from
// `from`, against the triangles of all obstacles. If the centre has crossed a surface, the body is
// put back along the path. The length of the path between its centre and the surface is then the
// inner radius (step_motion.h), or less if the path begins closer to the surface. The body keeps
// its velocity, and has contacts in the next step. Paths shorter than 1 % of the inner radius are
// not tested. Compound shapes are not tested either, because their centres may lie outside of them.
void stop_at_surfaces(btBroadphaseInterface& broadphase, const btVector3& from, btRigidBody& body);

}  // namespace loomstone
