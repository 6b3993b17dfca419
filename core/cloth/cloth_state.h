// What changes of all cloths. State: with the model it alone decides the future.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// State.
struct ClothState {
  Points x;            // (n x 3) [m], integrator, then certify
  Points v;            // (n x 3) [m/s], integrator, then certify
  Points last_change;  // (rows x 3) [m/s] change of velocity of the last implicit step, guess of
                       // the next; integrator
  // History of multi-step schemes (BDF-2, extrapolated bending); empty where there is none.
  // Integrator; cleared when certify moved a vertex.
  Points previous_x;        // (n x 3) [m]
  Points previous_v;        // (n x 3) [m/s]
  Points previous_bending;  // (n x 3) [N]

  // Multi-step schemes begin again, as after a jump of velocity.
  void restart_multistep() {
    previous_x.resize(0, 3);
    previous_v.resize(0, 3);
    previous_bending.resize(0, 3);
  }
  // Discards all that assumes a next step like the last one: multi-step history and the guess of
  // the solve.
  void forget_last_step() {
    restart_multistep();
    last_change.resize(0, 3);
  }
};

}  // namespace loomstone
