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

// Returns the length, in units of StepPart, to which contacts that have made energy from nothing
// shorten the part; the length of the part if they have not. They make energy if surfaces meet
// within the part: these are first felt at its end, where most of their thickness may have passed.
// The energy is tolerated up to a fraction of the largest kinetic energy so far. What scripted
// surfaces and prescribed vertices press into contacts is not made from nothing.
int length_without_gain(const StepContext& part, const Loads& loads, const NearContacts& near,
                        const Engines& engines, const State& state);

}  // namespace loomstone
