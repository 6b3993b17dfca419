#include "core/collision/narrow_phase/separation.h"

#include <limits>

#include "core/base/simd.h"

namespace loomstone {

namespace {

static_assert(query_lanes == n_lanes);

typedef decltype(Lanes{} < Lanes{}) Mask;

struct Vec3Lanes {
  Lanes x, y, z;
};

LOOMSTONE_INLINE Vec3Lanes operator+(const Vec3Lanes& a, const Vec3Lanes& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
LOOMSTONE_INLINE Vec3Lanes operator-(const Vec3Lanes& a, const Vec3Lanes& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
LOOMSTONE_INLINE Lanes dot(const Vec3Lanes& a, const Vec3Lanes& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
LOOMSTONE_INLINE Vec3Lanes cross(const Vec3Lanes& a, const Vec3Lanes& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
LOOMSTONE_INLINE Lanes absolute(const Lanes& a) { return a < 0.0 ? -a : a; }
LOOMSTONE_INLINE Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
LOOMSTONE_INLINE Lanes smaller(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
LOOMSTONE_INLINE Lanes size(const Vec3Lanes& a) {
  return larger(larger(absolute(a.x), absolute(a.y)), absolute(a.z));
}

LOOMSTONE_INLINE unsigned bits_of(const Mask& mask) {
  unsigned bits = 0;
  for (int i = 0; i < n_lanes; ++i) bits |= (mask[i] != 0) << i;
  return bits;
}

LOOMSTONE_INLINE Vec3Lanes difference(const QueryBatch& q, int i, int j) {
  return {lanes_load(q.x[i][0]) - lanes_load(q.x[j][0]),
          lanes_load(q.x[i][1]) - lanes_load(q.x[j][1]),
          lanes_load(q.x[i][2]) - lanes_load(q.x[j][2])};
}

// Differences a_i - b_j at both ends of the step. The sides are separated if all differences lie on
// one side of the origin along some direction.
template <int N>
struct Differences {
  Vec3Lanes start[N], end[N];
  Lanes size;

  LOOMSTONE_INLINE void set(const QueryBatch& q, int corner, int i, int j) {
    start[corner] = difference(q, i, j);
    end[corner] = difference(q, 4 + i, 4 + j);
    const Lanes now = larger(loomstone::size(start[corner]), loomstone::size(end[corner]));
    size = corner == 0 ? now : larger(size, now);
  }

  LOOMSTONE_INLINE Mask separated_by(const Vec3Lanes& n) const {
    // Bounds the rounding error of a difference (1/2 epsilon) and of a sum of three products.
    const Lanes error = 4.0 * std::numeric_limits<double>::epsilon() *
                            (absolute(n.x) + absolute(n.y) + absolute(n.z)) * size +
                        1e-300;
    Lanes low = dot(n, start[0]), high = low;
    for (int k = 0; k < N; ++k) {
      const Lanes s = dot(n, start[k]), e = dot(n, end[k]);
      low = smaller(low, smaller(s, e));
      high = larger(high, larger(s, e));
    }
    return (low > error) | (high < -error);
  }
};

}  // namespace

LOOMSTONE_CLONES unsigned surely_apart_vertex_face(const QueryBatch& batch) {
  Differences<3> d;
  for (int j = 0; j < 3; ++j) d.set(batch, j, 0, 1 + j);
  // The first direction is the face normal at half time, up to a factor. The second direction is
  // the line of centres.
  const auto middle = [&](int k) { return d.start[k] + d.end[k]; };
  Mask apart = d.separated_by(cross(middle(1) - middle(0), middle(2) - middle(0)));
  if (bits_of(apart) == 0xffu) return 0xffu;
  apart |= d.separated_by(middle(0) + middle(1) + middle(2));
  return bits_of(apart);
}

LOOMSTONE_CLONES unsigned surely_apart_edge_edge(const QueryBatch& batch) {
  Differences<4> d;
  d.set(batch, 0, 0, 2);
  d.set(batch, 1, 0, 3);
  d.set(batch, 2, 1, 3);
  d.set(batch, 3, 1, 2);
  const auto middle = [&](int k) { return d.start[k] + d.end[k]; };
  Mask apart = d.separated_by(cross(middle(1) - middle(0), middle(3) - middle(0)));
  if (bits_of(apart) == 0xffu) return 0xffu;
  apart |= d.separated_by(middle(0) + middle(2));
  return bits_of(apart);
}

}  // namespace loomstone
