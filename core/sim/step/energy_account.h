// Account of energy: the work that scripts and loads have done since the start, and the losses.
#pragma once

#include "core/sim/step/limit_and_certify.h"
#include "core/sim/step/work.h"

namespace loomstone {

// Begins the account of a state that has none. `state` is that at the start of a step.
void begin_account(const Engines& engines, State& state);

// What happened in a part after its solve.
struct AfterSolve {
  double limited = 0.0;        // energy of cloth that strain limits took [J]
  bool untangles = false;      // forces that untangle acted
  bool surfaces_move = false;  // some scripted surface moved
};

// Adds the work and the losses of a part. Certification has taken the energy that cloth and bodies
// lost after the solve, except what strain limits took.
void add_to_account(const PartWork& work, const Solved& solved, const AfterSolve& after,
                    const Engines& engines, State& state);

// Sets the account and the balances in a report whose energies are those of `state`.
void report_account(const State& state, StepReport& report);

// Returns whether contacts have made energy from nothing in the part, by more than a share of the
// largest kinetic energy so far: surfaces that meet within a part are first felt at its end, where
// most of their thickness may have passed.
bool contacts_gain_energy(const StepContext& part, const NearContacts& near, const Engines& engines,
                          const State& state);

}  // namespace loomstone
