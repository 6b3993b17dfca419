// Contacts at seams between obstacles whose surfaces are flush.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// Largest difference in height of flush surfaces, in contact distances (Bullet's contact breaking
// threshold, about a fiftieth of the size of a body).
inline constexpr btScalar flush_share = 0.02;

// A collision algorithm knows one pair. Where a sphere meets an obstacle A near its seam with B,
// the algorithm for B finds that the motion of the sphere, which A stops, ends at the edge of B.
// Removes such contacts: those that the motion of a sphere in a step [s] would close, but that this
// motion does not reach after earlier contacts with other obstacles have blocked a part of it.
void remove_contacts_behind_others(btDispatcher& dispatcher, btScalar step);

}  // namespace loomstone
