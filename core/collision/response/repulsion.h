// Response to contacts by impulses, for integrators without contact terms in an implicit solve.
// Stopping impulses ([Thomaszewski2010], (2.58), (2.59)) end the approach of features closer than
// their thickness. Repulsive impulses gradually move these features apart, almost to their
// thickness. Both act with Coulomb friction. In contrast to [Thomaszewski2010], friction acts on
// the relative tangential velocity of the contact instead of the velocity of each vertex, and the
// impulses of all contacts are solved together (method.md, Response by impulses).
#pragma once

#include <vector>

#include "core/collision/model/contact.h"
#include "core/collision/model/free_body.h"
#include "core/collision/response/response_inputs.h"

namespace loomstone {

// Corrects the end positions x1 of cloth and bodies, and the end poses of `bodies`, for the
// contacts and the intersections at x0. A correction divided by `step` [s] is the change of
// velocity.
void repel(const CollisionModel& model, const MotionInputs& inputs,
           const std::vector<Contact>& contacts, double step, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
