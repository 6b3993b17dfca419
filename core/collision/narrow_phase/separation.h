// Batched filter that precedes continuous collision detection. A query is a pair of features. The
// filter finds queries whose two features are certainly separated during the whole step. If a
// direction separates the features at both ends of the step, with the same feature in front, this
// direction separates them throughout, because projections of points onto a direction are linear in
// time. Eight queries are processed at once.
#pragma once

#include <algorithm>

#include "core/collision/narrow_phase/continuous.h"

namespace loomstone {

inline constexpr int query_lanes = 8;

// Eight queries in structure-of-arrays layout. Element x[i][k][q] is coordinate k [m] of point i of
// query q. Points 0 to 3 are the four vertices at the start of the step, and points 4 to 7 the same
// vertices at the end of the step.
struct alignas(64) QueryBatch {
  double x[8][3][query_lanes];

  void set(int lane, int point, const double* position) {
    for (int k = 0; k < 3; ++k) x[point][k][lane] = position[k];
  }
};

// Both functions return a bit mask. Bit i is set if query i is certainly separated.
unsigned surely_apart_vertex_face(const QueryBatch& batch);
unsigned surely_apart_edge_edge(const QueryBatch& batch);

// Calls rest(i), in ascending order of i, for each query i in [0, n) that the filter leaves
// undecided. point(i, k) returns the address of point k of query i; points are numbered as in
// QueryBatch.
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
