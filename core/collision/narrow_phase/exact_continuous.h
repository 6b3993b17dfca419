// Exact continuous collision detection: do a vertex and a face, or two edges, touch at any time in
// [0, 1] while their points move on straight lines? Touching counts; all degenerate cases are
// handled. Integer arithmetic without rounding: slow (10 to 100 us), for queries that floating
// point leaves undecided.
#pragma once

#include "core/collision/narrow_phase/continuous.h"

namespace loomstone {

// For finite points of any magnitude.
bool exactly_meet_vertex_face(const MovingPoints& points);
bool exactly_meet_edge_edge(const MovingPoints& points);

struct ExactImpact {
  bool hit = false;
  double time = 1.0;  // lower bound of the first contact time [1]
};

// Decided in floating point where rounding permits a proof, otherwise by integers.
ExactImpact exact_continuous_vertex_face(const MovingPoints& points);
ExactImpact exact_continuous_edge_edge(const MovingPoints& points);

}  // namespace loomstone
