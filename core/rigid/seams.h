// Contacts at seams between obstacles whose surfaces are flush.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// Largest difference in height of flush surfaces, in contact distances (Bullet's contact breaking
// threshold, about 1 % of the diagonal of a body's bounding box).
inline constexpr btScalar flush_share = 0.02;

// Removes wrong contacts of spheres at seams. Each collision algorithm knows only one pair. If a
// sphere meets obstacle A near its seam with obstacle B, the algorithm for B does not know that A
// stops the sphere, and finds a contact at the edge of B. If nothing stopped the sphere, it would
// reach this edge in the step of length `step` [s]. But contacts with other obstacles that it
// reaches earlier block a part of its motion, and the rest of the motion passes the edge. A contact
// is kept if the blocked part is longer than half the radius, or if the sphere stops after the
// step.
void remove_contacts_behind_others(btDispatcher& dispatcher, btScalar step);

}  // namespace loomstone
