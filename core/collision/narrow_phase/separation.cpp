#include "core/collision/narrow_phase/separation.h"

#include <limits>

#include "core/base/lane_bits.h"
#include "core/base/lane_vectors.h"

namespace loomstone {

namespace {

static_assert(query_lanes == n_lanes);

template <class Lanes>
LOOMSTONE_INLINE Lanes3<Lanes> plus(const Lanes3<Lanes>& a, const Lanes3<Lanes>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Lanes>
LOOMSTONE_INLINE Lanes absolute(const Lanes& a) {
  return lanes_select(a < 0.0, -a, a);
}
template <class Lanes>
LOOMSTONE_INLINE Lanes largest(const Lanes3<Lanes>& a) {
  return lanes_max(lanes_max(absolute(a.x), absolute(a.y)), absolute(a.z));
}

template <class Lanes>
LOOMSTONE_INLINE Lanes3<Lanes> difference(const QueryBatch& q, int i, int j) {
  return minus(lanes3_load<Lanes>(q.x[i][0], query_lanes),
               lanes3_load<Lanes>(q.x[j][0], query_lanes));
}

// Differences a_i - b_j of the points of two features at both ends of the step. The features
// are separated if all differences lie on one side of the origin along some direction.
template <class Lanes, int N>
struct BatchDifferences {
  Lanes3<Lanes> start[N], end[N];
  Lanes size;

  LOOMSTONE_INLINE void set(const QueryBatch& q, int corner, int i, int j) {
    start[corner] = difference<Lanes>(q, i, j);
    end[corner] = difference<Lanes>(q, 4 + i, 4 + j);
    const Lanes now = lanes_max(largest(start[corner]), largest(end[corner]));
    size = corner == 0 ? now : lanes_max(size, now);
  }

  // Returns twice the value of difference k at the middle of the step.
  LOOMSTONE_INLINE Lanes3<Lanes> middle(int k) const { return plus(start[k], end[k]); }

  LOOMSTONE_INLINE MaskOf<Lanes> separated_by(const Lanes3<Lanes>& n) const {
    // Bound on the rounding errors of the dot products below. In units of |n|_1 times `size`, the
    // differences contribute at most 1/2 epsilon, and products and sums at most 3/2 epsilon.
    const Lanes error = 4.0 * std::numeric_limits<double>::epsilon() *
                            (absolute(n.x) + absolute(n.y) + absolute(n.z)) * size +
                        1e-300;
    Lanes low = dot(n, start[0]), high = low;
    for (int k = 0; k < N; ++k) {
      const Lanes s = dot(n, start[k]), e = dot(n, end[k]);
      low = lanes_min(low, lanes_min(s, e));
      high = lanes_max(high, lanes_max(s, e));
    }
    return (low > error) | (high < -error);
  }
};

template <class Lanes>
LOOMSTONE_INLINE unsigned apart_vertex_face(const QueryBatch& batch) {
  BatchDifferences<Lanes, 3> d;
  for (int j = 0; j < 3; ++j) d.set(batch, j, 0, 1 + j);
  // The first direction is the face normal at the middle of the step, up to a factor. The second
  // direction is the line of centres.
  const auto first =
      d.separated_by(cross(minus(d.middle(1), d.middle(0)), minus(d.middle(2), d.middle(0))));
  if (lanes_bits(first) == 0xffu) return 0xffu;
  return lanes_bits(first | d.separated_by(plus(plus(d.middle(0), d.middle(1)), d.middle(2))));
}

template <class Lanes>
LOOMSTONE_INLINE unsigned apart_edge_edge(const QueryBatch& batch) {
  BatchDifferences<Lanes, 4> d;
  d.set(batch, 0, 0, 2);
  d.set(batch, 1, 0, 3);
  d.set(batch, 2, 1, 3);
  d.set(batch, 3, 1, 2);
  const auto first =
      d.separated_by(cross(minus(d.middle(1), d.middle(0)), minus(d.middle(3), d.middle(0))));
  if (lanes_bits(first) == 0xffu) return 0xffu;
  return lanes_bits(first | d.separated_by(plus(d.middle(0), d.middle(2))));
}

}  // namespace

unsigned surely_apart_vertex_face(const QueryBatch& batch) {
  return LOOMSTONE_WIDEST(apart_vertex_face)(batch);
}

unsigned surely_apart_edge_edge(const QueryBatch& batch) {
  return LOOMSTONE_WIDEST(apart_edge_edge)(batch);
}

}  // namespace loomstone
