// What Bullet does where the boxes of two bodies overlap.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// Separating axes for hull against hull only: against the triangles of an obstacle Bullet would make a polyhedron of every
// triangle in every step (fifteen times the time).
void meet(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info);

}  // namespace loomstone
