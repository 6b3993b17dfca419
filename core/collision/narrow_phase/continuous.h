// Continuous collision detection (narrow phase) of a vertex and a face, and of two edges, whose
// points move on straight lines during a step. Conservative advancement by separating planes: a
// plane of fixed direction n separates the two sides as long as n . (a_i(t) - b_j(t)) > floor for
// all pairs (i, j) of their points. This is linear in t, so the time until which it holds is known
// exactly; there a new direction is chosen. Only a motion with such a proof (with an allowance for
// rounding) counts as free, so no collision is missed; every other motion counts as a hit. Our
// choice; advancing to a safe time follows additive continuous collision detection [Li2021].
#pragma once

#include <array>

#include "core/base/types.h"
#include "core/collision/narrow_phase/distance.h"

namespace loomstone {

// Four points at the start, then the same four at the end of the step.
using MovingPoints = std::array<Vec3, 8>;

struct Impact {
  bool hit = false;
  bool touching = false;  // already within the floor (and rounding) at the start
  // Lower bound of the first time in [0, 1] at which the distance falls to the floor.
  double time = 1.0;
  double start_distance = 0.0;      // [m]; only where hit
  std::array<double, 4> weights{};  // closest points at `time`; only where hit
  Vec3 normal = Vec3::Zero();       // unit, from b to a at `time`; only where hit
};

// A hit is a distance at or below `floor` [m] at any time in [0, 1].
Impact continuous_vertex_face(const MovingPoints& points, double floor = 0.0);
Impact continuous_edge_edge(const MovingPoints& points, double floor = 0.0);

// The same with a gap floor that prevents gaps from collapsing step by step: 1e-5 m for pairs that
// start more than twice as far apart, half the start distance down to 1e-7 m, 0.9 of it below. With
// 0.1 of it, gaps shrank from 7e-10 to 1e-17 m in 13 steps.
inline constexpr double largest_gap_floor = 1e-5;  // [m]
double gap_floor(double start_distance);
Impact continuous_vertex_face_above_gap(const MovingPoints& points);
Impact continuous_edge_edge_above_gap(const MovingPoints& points);

}  // namespace loomstone
