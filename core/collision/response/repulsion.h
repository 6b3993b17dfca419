// Proximity response by impulses, for integrators without contact terms in an implicit solve:
// stopping impulses (2.58, 2.59) end the approach of vertices closer than their thickness,
// repulsive ones restore the thickness gradually, with Coulomb friction. Departures from
// [Thomaszewski2010] (method.md, response by impulses): friction acts on the relative
// tangential velocity of the contact, not of each vertex; the impulses of all contacts are solved
// together.
#pragma once

#include <vector>

#include "core/collision/model/contact.h"
#include "core/collision/model/free_body.h"
#include "core/collision/response/response_inputs.h"

namespace loomstone {

// Corrects the ends x1 of cloth and `bodies` for the contacts of x0. Divided by the step [s],
// corrections are changes of velocity.
void repel(const CollisionModel& model, const MotionInputs& inputs,
           const std::vector<Contact>& contacts, double step, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
