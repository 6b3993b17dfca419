// Account of energy: the work that scripts and loads have done since the start, and the losses.
#pragma once

#include "core/sim/step/near_contacts.h"

namespace loomstone {

// Begins the account of a state that has none. `state` is that at the start of a step.
void begin_account(const Engines& engines, State& state);

// Velocities after the solve, before limits and certification change them [m/s].
struct SolvedVelocities {
  Points cloth, bodies;  // (n x 3), (2 b x 3) translations and rotations
};

// Adds the work and the losses of a part. Elastic forces are the mean of the start and the end, and
// contact forces are those of the solve. The work on a prescribed vertex is the change of its
// kinetic energy less the work of these forces on it.
void add_to_account(const StepContext& part, const Loads& loads, NearContacts& near,
                    const SolvedVelocities& solved, Engines& engines, State& state);

// Sets the account and the balance in a report whose energies are those of `state`.
void report_account(const State& state, StepReport& report);

}  // namespace loomstone
