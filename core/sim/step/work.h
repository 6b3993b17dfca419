// Work of scripted motion and loads in a part of a step, and work against friction and viscosity.
#pragma once

#include "core/sim/step/move_bodies.h"
#include "core/sim/step/near_contacts.h"

namespace loomstone {

// Cloth and bodies after the solve and the stage that moves the bodies, before limiting and
// certification change them.
struct Solved {
  // (n x 3) Positions [m] and velocities [m/s] of cloth, copied before a later stage changes them;
  // no rows: State::cloth still contains them.
  Points x, v;
  // (2 b x 3) Velocity [m/s] and angular velocity [rad/s] of each body, from the solve.
  Points body_velocity;
  double body_energy = 0.0;  // kinetic and gravitational energy of the bodies [J]
  MovedBodies moved;

  const Points& positions(const ClothState& now) const { return x.rows() > 0 ? x : now.x; }
  // Copies the positions and velocities of cloth, unless they are already copied.
  void keep(const ClothState& cloth) {
    if (x.rows() == 0) x = cloth.x, v = cloth.v;
  }
};

struct PartWork {
  double scripts = 0.0;  // work of scripted motion, without that in CircuitState::supply [J]
  // Work done by air, the user's forces and torques, untangling, and impulses that restore gaps at
  // events [J]
  double loads = 0.0;
  double friction = 0.0;  // work done against friction of contacts, in the solve or at events [J]
  double damping = 0.0;   // work done against viscosity and bending damping [J]
};

// Returns the work of a part [J]. Elastic forces are the means of those at the start and at the end
// of the part, unless Integrator::work_on_prescribed() measures their work. Viscous forces are
// those in the middle of the motion at its mean velocity. Contact forces and the forces of limit
// phases are those of the solve. The work of the script on a prescribed vertex is the change of its
// kinetic energy minus the work that these forces and the loads, including the weight, do on it.
// With a Newton scheme, also sets the gradients of the terms in `near` to those that the solve
// used.
PartWork work_of_part(const StepContext& part, const Loads& loads, NearContacts& near,
                      const Solved& solved, const State& state, Engines& engines);

// Stores in `solved` the velocities of bodies from the solve, and the energy that bodies have in
// `state`. Removes the copies of positions and velocities of cloth from `solved`. A stage that
// changes the cloth must first copy its positions and velocities, for example by Solved::keep().
void note_solved(const Engines& engines, const State& state, const Points& body_velocity,
                 Solved& solved);

// Returns whether some obstacle moves in the part. Returns false if there is no cloth.
bool surfaces_move(const Loads& loads);

}  // namespace loomstone
