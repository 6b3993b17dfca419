// Continuous collision detection (narrow phase) for vertex-face and edge-edge pairs whose points
// move on straight lines during a step. The method is conservative advancement with separating
// planes. A plane with unit normal n keeps features a and b more than `floor` apart as long as
// n . (a_i(t) - b_j(t)) > floor for all points a_i of a and b_j of b. The left-hand side is linear
// in t, so the time at which separation ends has a closed form. The method advances to this time
// and chooses a new normal there. The advance is repeated, as in additive continuous collision
// detection [Li2021]. A motion without a proof of separation counts as an impact. The proof allows
// for rounding.
#pragma once

#include <array>

#include "core/base/types.h"
#include "core/collision/narrow_phase/distance.h"

namespace loomstone {

// Four points at the start of the step, then the same four points at the end.
using MovingPoints = std::array<Vec3, 8>;

struct Impact {
  bool hit = false;
  bool touching = false;  // the distance at the start is at or below the floor, up to rounding
  // Lower bound on the first time in [0, 1] at which the distance is at most the floor; 1 without
  // an impact.
  double time = 1.0;
  double start_distance = 0.0;      // [m]; set only if `hit` is true
  std::array<double, 4> weights{};  // weights of the closest points at `time`, if `hit`
  Vec3 normal = Vec3::Zero();       // unit normal from b to a at `time`, if `hit`
};

// Both functions return an impact if the distance is at most `floor` [m] at some time in [0, 1].
// They also return an impact if they cannot prove separation.
Impact continuous_vertex_face(const MovingPoints& points, double floor = 0.0);
Impact continuous_edge_edge(const MovingPoints& points, double floor = 0.0);

// Like continuous_vertex_face() and continuous_edge_edge(), but the floor is gap_floor() of the
// start distance and `largest_gap_floor` [m].
Impact continuous_vertex_face_above_gap(const MovingPoints& points, double largest_gap_floor);
Impact continuous_edge_edge_above_gap(const MovingPoints& points, double largest_gap_floor);

// Returns the gap floor [m], the distance that two features must keep during the step. It is
// `largest` if the start distance is above twice `largest`, and otherwise half the start distance.
// If the start distance is at most a hundredth of `largest`, the gap floor is 0.9 of the start
// distance instead, so that tiny gaps do not shrink fast over many steps.
double gap_floor(double start_distance, double largest);

}  // namespace loomstone
