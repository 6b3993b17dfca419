// Resolves intersections. Terms of an implicit solve or impulses move each piercing edge out of its
// triangle. Both act at the common point of edge and triangle and conserve momentum.
#pragma once

#include <vector>

#include "core/collision/response/impulses.h"
#include "core/collision/response/response_inputs.h"
#include "core/linalg/extra_terms.h"

namespace loomstone {

void untangling_terms(const CollisionModel& model, const Tangle& tangle,
                      const ContactInputs& inputs, ExtraTerms& terms);

std::vector<ImpulseContact> untangling_impulses(const Tangle& tangle, const Impulses& impulses,
                                                const Points& x0, const Points& x1, double step);

}  // namespace loomstone
