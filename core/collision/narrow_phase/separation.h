// Batches of continuous tests: which of many queries are surely apart during the whole step? A
// plane of fixed direction that separates the sides at both ends of the step separates them all the
// time, since its distances are linear in time. Eight queries are worked at once.
#pragma once

#include <algorithm>

#include "core/collision/narrow_phase/continuous.h"

namespace loomstone {

inline constexpr int query_lanes = 8;

// Eight queries, coordinate by coordinate: points at the start, then at the end.
struct alignas(64) QueryBatch {
  double x[8][3][query_lanes];

  void set(int lane, int point, const double* position) {
    for (int k = 0; k < 3; ++k) x[point][k][lane] = position[k];
  }
};

// Bit i: query i is surely apart.
unsigned surely_apart_vertex_face(const QueryBatch& batch);
unsigned surely_apart_edge_edge(const QueryBatch& batch);

// Calls rest(i) for those i of [0, n) that this leaves open, in order. point(i, k): address of the
// k-th of the eight points of query i, first the four at the start, as for MovingPoints.
template <class Point, class Rest>
void without_separated(bool vertex_face, Index n, Point&& point, Rest&& rest) {
  QueryBatch batch;
  for (Index begin = 0; begin < n; begin += query_lanes) {
    const Index here = std::min<Index>(query_lanes, n - begin);
    for (int lane = 0; lane < query_lanes; ++lane)
      for (int k = 0; k < 8; ++k) batch.set(lane, k, point(begin + (lane < here ? lane : 0), k));
    const unsigned apart =
        vertex_face ? surely_apart_vertex_face(batch) : surely_apart_edge_edge(batch);
    for (int lane = 0; lane < here; ++lane)
      if (!((apart >> lane) & 1u)) rest(begin + lane);
  }
}

}  // namespace loomstone
