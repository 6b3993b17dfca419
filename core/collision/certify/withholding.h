// Withholds motion of individual cloth vertices and bodies until no pair collides (method.md,
// Certification). The motion then has no impacts unless CertifyReport::unresolved is positive, for
// example because prescribed motion leaves the cloth no room.
#pragma once

#include <vector>

#include "core/collision/certify/certify_report.h"
#include "core/collision/certify/impact_search.h"
#include "core/collision/model/free_body.h"

namespace loomstone {

// Withholds motion of movable vertices and of whole free bodies. `impacts` are those of the motion
// to x1. A vertex that collides with a moving obstacle follows the obstacle. The vertex first loses
// only motion relative to the obstacle, and is then tested again. Returns a report in which the
// caller must set CertifyReport::impacts.
CertifyReport withhold_motion(const Team& team, ImpactSearch& search, const MotionInputs& inputs,
                              std::vector<StepImpact> impacts, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
