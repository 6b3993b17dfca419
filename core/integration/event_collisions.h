// Collisions at events within an asynchronous step, as the integrator sees them.
#pragma once

#include <vector>

#include "core/base/event_body.h"
#include "core/parallel/team.h"

namespace loomstone {

// Vertices in the middle of a step. They move at constant velocity from one of their events to the
// next.
struct EventVertices {
  Points &x, &v;                           // (n x 3) x is the position at the vertex's next event
  const std::vector<std::uint8_t>& level;  // (n) level of each vertex
  const std::vector<double>& step;         // (levels) time between the events of a vertex [s]
  const std::vector<double>& ahead;        // (levels) time from now to the next event [s]
  // Rigid bodies, whose poses are also those at their next events. Collisions change their
  // velocities only.
  std::vector<EventBody>& bodies;
};

class EventCollisions {
 public:
  virtual ~EventCollisions() = default;
  // Begins the step, which has n_ticks ticks, or begins it again.
  virtual void begin(Index n_ticks) = 0;
  // Changes the velocities of vertices and bodies at a tick, and the positions of vertices
  // accordingly.
  virtual void act(const Team& team, Index tick, const EventVertices& vertices) = 0;
};

}  // namespace loomstone
