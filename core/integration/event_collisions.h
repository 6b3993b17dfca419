// Interface by which an asynchronous integrator handles collisions at events. Nested steps divide a
// step into equal ticks, and their events take place at the boundaries of ticks.
#pragma once

#include <vector>

#include "core/base/event_motion.h"
#include "core/parallel/team.h"

namespace loomstone {

class EventCollisions {
 public:
  virtual ~EventCollisions() = default;
  // Begins or repeats a step that is divided into n_ticks ticks of equal length. n_ticks is 0 if a
  // queue orders the events.
  virtual void begin(Index n_ticks) = 0;
  // At the start of a tick, changes the velocities of vertices and bodies that collide. If
  // EventMotion::ahead() of a vertex is not 0, its stored position belongs to another time and
  // depends on the velocity, so act() changes this position, too. The caller must change the poses
  // of bodies in the same way.
  virtual void act(const Team& team, Index tick, const EventMotion& motion) = 0;
  // Does the same as act() in an event of a queue, but only for pairs of features that contain a
  // vertex of `vertices`. Prescribed vertices in this list are ignored.
  virtual void act_on(const std::vector<Index>& vertices, const EventMotion& motion) = 0;
};

}  // namespace loomstone
