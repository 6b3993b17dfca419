// The exact verdict of a continuous test: do a vertex and a face, or two edges, touch at any time in [0, 1] while their
// points move on straight lines? Touching counts; everything may be degenerate. Integers without rounding: slow (some 10 to
// 100 us), for queries that floating point leaves open.
#pragma once

#include "core/collision/continuous.h"

namespace loomstone {

// For finite points of any magnitude.
bool exactly_meet_vertex_face(const MovingPoints& points);
bool exactly_meet_edge_edge(const MovingPoints& points);

// The conservative test at floor 0 with its hits confirmed by proof or, where that is left open, by integers: an exact verdict
// and a lower bound of the time of the first contact.
Impact exact_continuous_vertex_face(const MovingPoints& points);
Impact exact_continuous_edge_edge(const MovingPoints& points);

// Proof by floating point that they meet: the sides change over while the closest points stay inside. False where rounding
// leaves it open.
bool surely_meet_vertex_face(const MovingPoints& points);
bool surely_meet_edge_edge(const MovingPoints& points);

}  // namespace loomstone
