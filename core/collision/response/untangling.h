// Moves each piercing edge out of the triangle that it pierces, if the direction in which it must
// move is known. This is done by terms added to the implicit solve, or by impulses. The forces or
// impulses on edge and triangle are equal and opposite and act at their common point.
// untangling_terms() also accelerates the vertices of retracted surfaces.
#pragma once

#include <vector>

#include "core/collision/response/impulses.h"
#include "core/collision/response/response_inputs.h"
#include "core/collision/response/retraction.h"
#include "core/linalg/extra_terms.h"

namespace loomstone {

void untangling_terms(const CollisionModel& model, const Tangle& tangle,
                      const ContactInputs& inputs, ExtraTerms& terms);

std::vector<ImpulseContact> untangling_impulses(const Tangle& tangle, const RetractedMotion& motion,
                                                const Impulses& impulses, const Points& x0,
                                                const Points& x1, double step);

}  // namespace loomstone
