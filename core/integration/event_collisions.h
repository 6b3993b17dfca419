// Collisions at events within an asynchronous step, as the integrator sees them.
#pragma once

#include <vector>

#include "core/base/event_motion.h"
#include "core/parallel/team.h"

namespace loomstone {

class EventCollisions {
 public:
  virtual ~EventCollisions() = default;
  // Begins the step, which has n_ticks ticks, or begins it again. A queue has none.
  virtual void begin(Index n_ticks) = 0;
  // Changes the velocities of vertices and bodies at a tick, and the positions of vertices
  // accordingly.
  virtual void act(const Team& team, Index tick, const EventMotion& motion) = 0;
  // The same in an event of a queue, for the pairs with one of the listed vertices.
  virtual void act_on(const std::vector<Index>& vertices, const EventMotion& motion) = 0;
};

}  // namespace loomstone
