// Second stage: contacts and intersections at the start of a part of a step, and their terms in the
// implicit solve.
#pragma once

#include <vector>

#include "core/sim/step/loads.h"

namespace loomstone {

struct NearContacts {
  std::vector<Contact> contacts;  // pairs closer than their thickness
  // Contacts that impulses after the solve respond to; none if the integrator handles them at
  // events.
  std::vector<Contact> repelled;
  ExtraTerms terms;  // of contacts, then of intersections to untangle, then of attachments
  std::size_t n_attachments = 0;
  ContactTerms contact_terms;  // evaluates the terms of contacts during the solve
  Tangle tangle;               // intersections at the start
  // (vertices x 3) predicted velocities of all collision vertices [m/s]; only with contacts in the
  // solve or at events
  Points v0;
  // (vertices x 3) change of velocity in the last step [m/s]. Contact terms assume that it repeats
  // in this step, which reduces the lag of sliding contacts.
  Points last_change;
};

void find_near_contacts(const StepContext& part, const Loads& loads, const State& state,
                        Engines& engines, NearContacts& near, StepReport& report);

// Evaluates the terms for an iterate of Newton's method, after cloth and bodies have moved by
// `displacement` (rows x 3) [m] in `time` [s]. On entry, `terms` are those of the start. Returns
// their energy [J].
double terms_at(NearContacts& near, const Engines& engines, const Points& displacement, double time,
                TermRequest request, ExtraTerms& terms);

}  // namespace loomstone
