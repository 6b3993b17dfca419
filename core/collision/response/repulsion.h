// Proximity response by impulses, for what has no contact terms in an implicit solve: stopping
// impulses (2.58, 2.59) that end the approach of what is closer than its thickness, repelling ones
// that restore the thickness softly, and Coulomb friction. Departures from the thesis (method.md
// 2): friction acts on the relative tangential velocity of the contact, not on that of each vertex;
// the impulses of all contacts are solved together, each keeping what the others have done.
#pragma once

#include <vector>

#include "core/collision/model/contact.h"
#include "core/collision/model/free_body.h"
#include "core/collision/response/response_inputs.h"

namespace loomstone {

// Contacts are those of x0, `step` is h [s]. Moves the ends x1 of cloth and `bodies`; divided by h
// these are changes of velocity.
void repel(const CollisionModel& model, const MotionInputs& inputs,
           const std::vector<Contact>& contacts, double step, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
