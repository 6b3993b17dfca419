// State of all cloths, including what later steps need from earlier ones.
#pragma once

#include "core/base/bytes.h"
#include "core/base/types.h"

namespace loomstone {

struct ClothState {
  // The integrator writes x and v. Later stages of the step may change them.
  Points x;  // (n x 3) positions [m]
  Points v;  // (n x 3) velocities [m/s]
  // (rows of the solve x 3) Change of velocity in the last step [m/s]; in rows of bodies, the
  // unknown y instead (see BodyRows in scheme_coefficients.h). Linearised schemes write it. The
  // next step uses the change to predict the slip of contacts or, without contacts, as the initial
  // guess of its solve.
  Points last_change;
  // Length of the step, or part of a step, that led to x and v [s]; 0 at the start and after the
  // user has set x or v. The stepper writes it.
  double previous_step = 0.0;
  // Expected length of the next step or part of a step [s]; 0: unknown. It follows from the error
  // of the last step or part or, with explicit schemes, from the stretch of the cloth. With
  // implicit Euler, numerical damping (see Damping in displacement_error.h) also bounds it. In
  // automatic steps, it is further bounded by the allowed growth and, while strain limits are
  // forced (see NearContacts::forced), by a fraction of the largest step. The stepper writes it.
  double expected_step = 0.0;
  // Largest length with which an automatic step created too much energy, so that it was repeated
  // with a smaller length [s]; 0: none. Later steps grow faster than usual until one of them has at
  // least this length, or until their error or numerical damping limits their growth. The stepper
  // writes it.
  double settled_step = 0.0;
  // (m) Longest step that each triangle may take [s]; empty if none has been computed. Entries
  // do not increase until forget_all() removes them. The asynchronous integrator writes them.
  Vector element_steps;
  // (e x 2) Time since the last event and time until the next event of each element [s]. Elements
  // are the triangles and then the bending groups (class BendingGroup) with events of their own.
  // Empty if there is no queue of events. The asynchronous integrator writes them.
  Points2 element_clocks;
  // (k x 3) Positions at the last event of each triangle (its three corners), followed by those at
  // the last event of each bending group (its vertices) [m]. Rows of triangles and groups without
  // damping are not used. Empty without damping or without a queue of events. The asynchronous
  // integrator writes them.
  Points element_positions;
  // History of midpoint and BDF-2: values at the start of the last step or part of a step. A table
  // is empty if its values are unknown or not needed. The integrator writes the tables. All of them
  // are cleared when strain limiting or certification moves a vertex, and the first two also in a
  // BDF-2 step with contacts.
  Points previous_x;        // (n x 3) positions [m]
  Points previous_v;        // (n x 3) velocities [m/s]
  Points previous_bending;  // (n x 3) forces of explicit bending [N]

  std::size_t bytes() const {
    return bytes_of(x, v, last_change, element_steps, element_clocks, element_positions, previous_x,
                    previous_v, previous_bending);
  }

  // Length of the last step or part of a step [s], or h if it is unknown.
  double last_length(double h) const { return previous_step > 0.0 ? previous_step : h; }
  // Length h [s] of the next step or part of a step, divided by last_length() [1]. If the
  // acceleration is constant, this is also the ratio of the changes of velocity in the two steps.
  double change_scale(double h) const { return h / last_length(h); }

  // Clears the history, so that multistep schemes restart, for example after a velocity jump.
  void restart_multistep() {
    previous_x.resize(0, 3);
    previous_v.resize(0, 3);
    previous_bending.resize(0, 3);
  }
  // Discards the multistep history and last_change. Call this function if the next step may differ
  // much from the last one.
  void forget_last_step() {
    restart_multistep();
    last_change.resize(0, 3);
  }
  // Discards everything that depends on past steps, for example after the user has set positions or
  // velocities.
  void forget_all() {
    forget_last_step();
    previous_step = expected_step = settled_step = 0.0;
    element_steps.resize(0);
    element_clocks.resize(0, 2);
    element_positions.resize(0, 3);
  }
};

}  // namespace loomstone
