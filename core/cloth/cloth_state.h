// State of all cloths. Model and state alone determine the future.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// State.
struct ClothState {
  Points x;  // (n x 3) [m]; written by the integrator, then by certification
  Points v;  // (n x 3) [m/s]; written by the integrator, then by certification
  // (rows x 3) [m/s] change of velocity in the last implicit step, the initial guess of the next
  // solve; written by the integrator.
  Points last_change;
  // History of multistep schemes (BDF-2, extrapolated bending); empty if there is none. Written by
  // the integrator, cleared when certification moves a vertex.
  Points previous_x;        // (n x 3) [m]
  Points previous_v;        // (n x 3) [m/s]
  Points previous_bending;  // (n x 3) [N]

  // Restarts multistep schemes, as after a jump of velocity.
  void restart_multistep() {
    previous_x.resize(0, 3);
    previous_v.resize(0, 3);
    previous_bending.resize(0, 3);
  }
  // Discards all that assumes a next step like the last one: multistep history and the guess of
  // the solve.
  void forget_last_step() {
    restart_multistep();
    last_change.resize(0, 3);
  }
};

}  // namespace loomstone
