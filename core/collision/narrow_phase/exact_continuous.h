// The exact verdict of a continuous test: do a vertex and a face, or two edges, touch at any time
// in [0, 1] while their points move on straight lines? Touching counts; everything may be
// degenerate. Integers without rounding: slow (some 10 to 100 us), for queries that floating point
// leaves open.
#pragma once

#include "core/collision/narrow_phase/continuous.h"

namespace loomstone {

// For finite points of any magnitude.
bool exactly_meet_vertex_face(const MovingPoints& points);
bool exactly_meet_edge_edge(const MovingPoints& points);

struct ExactImpact {
  bool hit = false;
  double time = 1.0;  // the first contact comes no sooner [1]
};

// Decided by proof in floating point where rounding allows it, by integers elsewhere.
ExactImpact exact_continuous_vertex_face(const MovingPoints& points);
ExactImpact exact_continuous_edge_edge(const MovingPoints& points);

}  // namespace loomstone
