// Account of energy: the work of scripted motion and loads since the account began, and the losses.
#pragma once

#include "core/sim/step/bisection.h"
#include "core/sim/step/limit_and_certify.h"
#include "core/sim/step/work.h"

namespace loomstone {

// Begins the account of `state` at the start of a step, unless the state already has an account.
void begin_account(const Engines& engines, State& state);

// Data from which add_to_account() finds the causes of changes of energy after the stage that moves
// the bodies.
struct AfterSolve {
  double limited = 0.0;        // energy that strain and strain-rate limiting removed from cloth [J]
  bool untangles = false;      // surfaces intersected at the start of the part
  bool surfaces_move = false;  // some obstacle moved
};

// Adds the work and the losses of a part to state.account, and updates its largest kinetic energy.
// The energy that cloth and bodies lose after the stage that moves the bodies is attributed to
// certification (EnergyAccount::withheld), except for the energy that strain limits remove. If the
// energy rises instead, the rise is attributed to untangling if `after.untangles` is true, else to
// scripts if `after.surfaces_move` is true, and otherwise also to certification.
// Returns this rise plus MovedBodies::carried_gain [J]; if one of them is negative, it counts as 0.
// Returns 0 if `after.untangles` is true.
double add_to_account(const PartWork& work, const Solved& solved, const AfterSolve& after,
                      const Engines& engines, State& state);

// Returns the energy that everything but contacts has gained from the beginning of the account to
// the start of a part, as a fraction of the tolerated gain [1]. The gain excludes the work of
// scripts, the work of loads, and the energy that contacts had when the account began. The
// tolerated gain is a fraction, scaled by ImplicitOptions::accuracy, of the largest of these
// energies: the largest kinetic energy so far, the work of scripts, the work of loads, and a bound
// on the energy of rounding errors. Returns 0 without an accuracy.
double relative_gain(const StepContext& part, const Engines& engines, const State& state);

// Sets the account and the balances in `report`, which must already have the energies and circuit
// values of `state`.
void report_account(const Model& model, const State& state, StepReport& report);

// Returns the result of an attempt at a part. If more energy has been created or lost than is
// tolerated, the result contains the length to which the part must be shortened. Checks only
// asynchronous steps with collisions and, if ImplicitOptions::accuracy is given and
// StepContext::halvable is true, implicit steps whose solve includes contacts. know_contacts()
// should have been called; otherwise contacts are found again.
//
// In implicit steps, a part is halved if everything but contacts has gained too much in it, beyond
// the work of scripts and loads, the energy that contacts have lost, and the energy that sweeps of
// strain limiting have added. It is also halved if everything but contacts has gained more than is
// tolerated since the account began, some of it in the part. Parts of schemes without damping are
// not checked if limit phases may store energy, unless contacts have more than the tolerated
// energy.
//
// Contacts create energy if surfaces approach each other within a part, because the contact force
// begins only at the end of the part. By then, the surfaces may be much closer than their
// thickness. The part is shortened if the energy of contacts has risen in it by more than is
// tolerated, and if the sum of all energies, minus the work of scripts and loads, has also risen by
// more than is tolerated. This second rise is the one since the account began. In automatic steps
// in which no pin moves, nothing is untangled and no triangle is in a limit phase, it is also the
// one in the part, with the energy that friction, damping, limits and certification have taken. In
// the shortened part, both are expected to be at most half of the tolerated energy, unless the part
// has the shortest permitted length. The tolerated energy is a fraction of the largest kinetic
// energy so far or of the energy of contacts at the start of the part, whichever is larger, because
// scripted surfaces may compress cloth that is at rest.
//
// With implicit Euler, a part is also halved if too much of the work that scripts did in it has
// vanished. This check is omitted if limit phases may store the work, if StepContext::saves_work is
// false, and in parts to which the bound of a quarter step (see below) applies. Work of scripts
// vanishes where cloth slides over an edge: the plane of a contact stays the same within a part, so
// contacts hold back the cloth.
//
// In asynchronous steps, certification creates energy if it stretches cloth at impacts that events
// have missed. A part is halved if `gained`, the result of add_to_account() [J], is too large,
// unless the part has the shortest permitted length.
//
// If the step is not automatic and obstacles move, and if pins also move or cloth has contacts,
// this function shortens no part to less than a quarter of the step. In asynchronous steps, moving
// obstacles suffice for this bound. The reason is that in shorter parts, impacts between cloth and
// scripted surfaces that approach the cloth quickly remain unresolved.
PartResult check_energy(const StepContext& part, const Loads& loads, const NearContacts& near,
                        double gained, const Engines& engines, const State& state);

}  // namespace loomstone
