// Interface by which an asynchronous integrator handles collisions at events. A step is divided
// into equal ticks, and events take place at the boundaries of ticks.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

// Vertices in the middle of a step. Each vertex moves at constant velocity from one of its events
// to the next. Vertices of the same level have their events at the same times.
struct EventVertices {
  Points &x, &v;  // (n x 3) position of each vertex at its next event [m], and velocity [m/s]
  const std::vector<std::uint8_t>& level;  // (n) level of each vertex
  const std::vector<double>& step;         // (levels) time between two events of the level [s]
  const std::vector<double>& ahead;  // (levels) time from now to the next event of the level [s]
};

class EventCollisions {
 public:
  virtual ~EventCollisions() = default;
  // Begins a step that is divided into n_ticks ticks, or restarts it.
  virtual void begin(Index n_ticks) = 0;
  // Changes the velocities of vertices after `tick` ticks and, accordingly, their positions at
  // their next events.
  virtual void act(const Team& team, Index tick, const EventVertices& vertices) = 0;
};

}  // namespace loomstone
