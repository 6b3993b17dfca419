// Withholds motion, vertex by vertex, until no pair collides (method.md, certification). A
// step that starts free of impacts ends free of impacts.
#pragma once

#include <vector>

#include "core/collision/certify/certify_report.h"
#include "core/collision/certify/impact_search.h"
#include "core/collision/model/free_body.h"

namespace loomstone {

// Withholds motion of vertices with an inverse mass, and of free bodies as a whole. A vertex that a
// moving obstacle hits is carried along: it follows the obstacle, loses only its relative motion,
// and is tested again.
CertifyReport withhold_motion(const Team& team, ImpactSearch& search, const MotionInputs& inputs,
                              std::vector<StepImpact> impacts, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
