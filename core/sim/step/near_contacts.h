// Second stage: what is near when a part of a step begins, and the terms that this adds to the
// implicit solve.
#pragma once

#include <vector>

#include "core/sim/step/loads.h"

namespace loomstone {

struct NearContacts {
  std::vector<Contact> contacts;  // closer than their thickness
  ExtraTerms terms;            // of contacts, then what moves intersections apart, then attachments
  ContactTerms contact_terms;  // of contacts, what updates their terms
  Tangle tangle;               // what intersects
  Points v0;  // (vertices x 3) expected velocities of all that collides; contacts in the solve only
              // [m/s]
  Points last_change;  // (vertices x 3) of velocity in the last step, expected again: sliding
                       // contacts lag less [m/s]
};

void find_near_contacts(const StepContext& part, const Loads& loads, const State& state,
                        Engines& engines, NearContacts& near, StepReport& report);

// The terms where cloth and bodies have moved by `displacement` (rows x 3) [m] in `time` [s] since
// the start, for Newton loops: `terms` come as those of the start. Returns their energy [J].
double terms_at(NearContacts& near, const Engines& engines, const Points& displacement, double time,
                TermRequest request, ExtraTerms& terms);

}  // namespace loomstone
