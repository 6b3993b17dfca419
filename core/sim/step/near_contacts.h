// Second stage: finds the contacts and intersections at the start of a part of a step, and the
// terms of the implicit solve, which include those of attachments.
#pragma once

#include <vector>

#include "core/parallel/repeated_gather.h"
#include "core/sim/step/loads.h"

namespace loomstone {

struct NearContacts {
  // Contacts at the start; none if the integrator handles them at events. If terms are divided,
  // only the contacts that this rank keeps (see CollisionStage::divide()).
  std::vector<Contact> contacts;
  ContactTotals totals;           // totals of the contacts of all ranks
  std::vector<Contact> repelled;  // contacts that receive impulses after the solve
  // Vertices of the contacts at the start, if the integrator handles contacts at events.
  std::vector<std::array<Index, 4>> touching;
  // Terms of contacts, of intersections to untangle, and of attachments, in this order. Terms of
  // contacts that act on no row of this rank may be omitted.
  ExtraTerms terms;
  bool terms_divided = false;     // true: each rank has the terms of its rows
  bool any_terms = false;         // some rank has terms of contacts
  std::size_t n_attachments = 0;  // number of terms of attachments
  ContactTerms contact_terms;     // evaluates the terms of contacts during the solve
  // forced[s] is 1 if surface s is a cloth whose strain limits are forced: at the start, at least
  // one of its triangles touches an obstacle and exceeds its limits by more than limit_margin().
  // yields[v] is 1 if cloth vertex v belongs to such a cloth and touches an obstacle. Both are
  // empty if no limits are forced.
  std::vector<std::uint8_t> forced, yields;
  double energy = 0.0;  // energy of all contacts at the start [J]; set after certification
  Tangle tangle;        // intersections at the start
  // (vertices x 3) predicted velocities of collision vertices [m/s]; set only if the integrator
  // handles contacts at events
  Points v0;
  GatherRoom work_room;
};

void find_near_contacts(const StepContext& part, const Loads& loads, const State& state,
                        Engines& engines, NearContacts& near, StepReport& report);

// Collective. Finds the contacts of `state`, if contacts are part of the solve. The next part and
// collective calls of contact_energies() use these contacts as long as the state does not change.
void know_contacts(const State& state, const Engines& engines);

// Returns the energy [J] of the contacts that the next part of the step would find in `state` at
// `time` [s]. The result has n_parts entries. If positions x0 are given, the motion from x0 to
// `state` is divided into n_parts intervals of equal length, and entry i is the energy at the end
// of interval i. All entries but the last are estimates. If contacts are not part of the solve, all
// entries are 0. Collective if `elasticity` is divided among ranks. Slow unless know_contacts() was
// called for this state, and always slow if a rank alone evaluates contacts that are divided among
// ranks.
std::vector<double> contact_energies(const State& state, double time, const Engines& engines,
                                     Elasticity& elasticity, const Points* x0 = nullptr,
                                     int n_parts = 1);

// Returns, for each collision surface, 1 if it is a body or a cloth that bodies load, otherwise 0.
// Bodies load a cloth if it is attached to a body, touches a body, or touches another cloth that
// bodies load.
std::vector<std::uint8_t> loaded_by_bodies(const Model& model, const ContactTotals& contacts);

// Returns the energy [J] of contacts at the end of a part, and keeps it in `engines` for reports.
// Collective. Slow unless know_contacts() was called for this state.
double energy_at_end(const State& state, double time, const Engines& engines);

// Returns the contacts in the present state, sorted by (kind, a, b); empty if the scene has no
// cloth or no collision handling. Collective.
std::vector<Contact> present_contacts(const State& state, const Engines& engines);

// Evaluates the terms for an iterate of Newton's method, after cloth and bodies have moved by
// `displacement` (rows x 3) [m, rad] in `time` [s]. On entry, `terms` are those at the start of the
// part. Returns their energy up to a constant [J].
double terms_at(NearContacts& near, const Engines& engines, const Points& displacement, double time,
                TermRequest request, ExtraTerms& terms);

}  // namespace loomstone
