// Withholds motion of individual cloth vertices and bodies to prevent impacts (method.md,
// Certification). The remaining motion has no impacts unless CertifyReport::unresolved is positive,
// for example because prescribed motion leaves the cloth no room.
#pragma once

#include <vector>

#include "core/collision/certify/certify_report.h"
#include "core/collision/certify/impact_search.h"
#include "core/collision/model/free_body.h"

namespace loomstone {

// Withholds motion of movable vertices and of whole free bodies. Corrects x1 and the end poses of
// `bodies`. `impacts` must be those of the motion from inputs.x0 to x1. A vertex or body that
// collides with vertices that certification cannot move, such as those of an obstacle, follows
// their motion (displacements.h). It first loses only motion relative to them, and is then tested
// again. Returns a report in which the caller must set CertifyReport::impacts.
CertifyReport withhold_motion(const Team& team, ImpactSearch& search, const MotionInputs& inputs,
                              std::vector<StepImpact> impacts, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
