// Exact continuous collision detection. Decides whether a vertex and a face, or two edges, touch at
// any time in [0, 1] while their points move on straight lines. All degenerate cases are handled.
// Integer arithmetic has no rounding but is slow (15 to 40 us per query), so the functions that
// return an ExactImpact use it only for queries that floating point leaves undecided.
#pragma once

#include "core/collision/narrow_phase/continuous.h"

namespace loomstone {

// Both functions decide by integer arithmetic alone whether the features touch. Points must be
// finite and can have any magnitude.
bool exactly_meet_vertex_face(const MovingPoints& points);
bool exactly_meet_edge_edge(const MovingPoints& points);

struct ExactImpact {
  bool hit = false;
  double time = 1.0;  // lower bound on the first contact time, in [0, 1]; 1 if `hit` is false
};

// Both functions use floating point where it can prove the result in spite of rounding, and exact
// integer arithmetic otherwise.
ExactImpact exact_continuous_vertex_face(const MovingPoints& points);
ExactImpact exact_continuous_edge_edge(const MovingPoints& points);

}  // namespace loomstone
