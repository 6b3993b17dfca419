// The state of a simulation. After steps that allow a checkpoint (Simulation::may_checkpoint()),
// the state is complete: Model, State and the options of the integrator determine all later steps.
// A checkpoint contains the entire State.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/cloth/cloth_state.h"
#include "core/collision/model/contact.h"
#include "core/electrodynamics/magnetic_state.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// Account of energy [J]. It begins with the first step. After the user has written positions or
// velocities, a new account begins with the next step.
struct EnergyAccount {
  bool begun = false;
  double start = 0.0;              // energy when the account began, without that of contacts
  double start_of_contacts = 0.0;  // energy of contacts when the account began
  double scripts = 0.0;            // work of scripted motion, without that in CircuitState::supply
  // Work done by air, the user's forces and torques, untangling, and impulses that restore gaps at
  // events.
  double loads = 0.0;
  double friction = 0.0;  // work done against friction of contacts, in the solve or at events
  double damping = 0.0;   // work done against viscosity and bending damping
  double limits = 0.0;    // energy of cloth lost to sweeps of strain and strain-rate limiting
  // Other energy that cloth and bodies lost after the solve, to certification and to impulses that
  // resolve contacts; see add_to_account().
  double withheld = 0.0;
  double largest_kinetic = 0.0;
};

// The part of the state that steps change. If a step or a part of a step fails, the stepper
// restores a copy that was made at the start of the step or part.
struct SteppedState {
  std::int64_t step = 0;  // completed steps; written by the stepper
  double time = 0.0;      // [s]; written by the stepper
  // Written by the integrator and by later stages. The stepper writes the lengths of steps in it.
  ClothState cloth;
  RigidState rigid;  // written by move_bodies() and certification; `manifolds`: by the stepper
  MagneticState magnetic;  // written by move_bodies()
  ContactState contacts;   // friction anchors, written by certification
  EnergyAccount account;   // written by the stepper; reset if users write positions or velocities
  // 0: no known intersections. 1: positions given by the user may intersect. 2: a step has ended
  // with unresolved impacts, and intersections that they left may remain. Written by build(), by
  // functions that set positions, and by the stepper.
  std::uint8_t tangled = 0;
  Points obstacle_vertices;  // (k x 3) vertices of all obstacles at the current time [m]
  // (k x 3) vertices of all obstacles at the start of the part that ended at obstacle_vertices [m];
  // no rows: there is no such part, or no obstacle had a pose set by the user in it
  Points previous_obstacle_vertices;

  std::size_t bytes() const {
    return bytes_of(cloth, contacts.anchors, obstacle_vertices, previous_obstacle_vertices,
                    rigid.manifolds);
  }
};

// A State is assigned by copying into its arrays, never by moving, because numpy views refer to the
// memory of these arrays. The members that State adds to SteppedState are set by the user and are
// constant during a step.
struct State : SteppedState {
  Points external_force;  // (n x 3) forces [N]; no rows: zero
  // (b x 3) forces at the centres of mass [N] and torques about them [N m]
  Points body_force, body_torque;
  // Time at which the motion to all targets and poses below is complete [s]. Until then, the
  // motion is linear in time. With steps of given length, it is complete at the end of the next
  // step.
  double target_time = 0.0;
  // (n) 1: the row of pin_target replaces the given motion of this prescribed vertex.
  std::vector<std::uint8_t> pin_override;
  Points pin_target;  // (n x 3) positions [m]; no rows: zero
  // One pose per obstacle, which replaces its keyframes or vertex_positions where pose_override is
  // 1. Positions are in [m], and orientations are quaternions (w, x, y, z).
  std::vector<std::uint8_t> pose_override;
  Points pose_position;
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> pose_orientation;

  std::size_t bytes() const {
    return SteppedState::bytes() + bytes_of(external_force, pin_override, pin_target);
  }
  // Returns `table`, which must be `external_force` or `pin_target`. If it has no rows, first gives
  // it a row of zeros for each cloth vertex.
  Points& made(Points& table) {
    if (table.rows() == 0) table = Points::Zero(cloth.x.rows(), 3);
    return table;
  }
};

}  // namespace loomstone
