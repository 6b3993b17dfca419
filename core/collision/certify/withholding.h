// Local truncation: what still collides at the end of a step is shortened until nothing does. Ends
// every step free of impacts, if it started so. notes: contact response, recommended step 4.
#pragma once

#include <vector>

#include "core/collision/certify/certify_report.h"
#include "core/collision/certify/impact_search.h"
#include "core/collision/model/free_body.h"

namespace loomstone {

// Shortens displacements of vertices with inverse mass, those of a free body together. What is hit
// by a moving script keeps that motion whole and loses only its motion relative to it: it is
// carried along, and tested again.
CertifyReport truncate(const Team& team, ImpactSearch& search, const MotionInputs& inputs,
                       std::vector<StepImpact> impacts, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
