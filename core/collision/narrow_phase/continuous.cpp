#include "core/collision/narrow_phase/continuous.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace loomstone {

namespace {

// Differences a_i - b_j of the points of two features at both ends of the step. Each coordinate is
// rounded only once.
template <int N>
struct Differences {
  std::array<Vec3, N> start, end;
  double rounding = 0.0;  // bound on the rounding error of n . (a_i - b_j), |n| = 1 [m]

  void finish() {
    double largest = 0.0;
    for (int k = 0; k < N; ++k)
      largest = std::max({largest, start[k].cwiseAbs().maxCoeff(), end[k].cwiseAbs().maxCoeff()});
    rounding = 32.0 * std::numeric_limits<double>::epsilon() * largest;
  }

  // Returns the last time in [time, 1] up to which the plane whose unit normal n points from b to a
  // keeps the features more than `floor` apart. Returns `time` if the plane does not do so even at
  // `time`.
  double advance(const Vec3& n, double time, double floor) const {
    double last = 1.0;
    for (int k = 0; k < N; ++k) {
      const double s0 = n.dot(start[k]), s1 = n.dot(end[k]);
      if ((1.0 - time) * s0 + time * s1 <= floor) return time;
      if (s1 <= floor) last = std::min(last, (s0 - floor) / (s0 - s1));
    }
    return std::max(last, time);
  }
};

Differences<3> vertex_face_differences(const MovingPoints& q) {
  Differences<3> d;
  for (int j = 0; j < 3; ++j) {
    d.start[j] = q[0] - q[1 + j];
    d.end[j] = q[4] - q[5 + j];
  }
  d.finish();
  return d;
}

Differences<4> edge_edge_differences(const MovingPoints& q) {
  Differences<4> d;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      d.start[2 * i + j] = q[i] - q[2 + j];
      d.end[2 * i + j] = q[4 + i] - q[6 + j];
    }
  d.finish();
  return d;
}

struct VertexFace {
  using D = Differences<3>;
  static D differences(const MovingPoints& q) { return vertex_face_differences(q); }
  static ClosestPair closest(const FourPoints& p) { return closest_vertex_face(p); }
  static Vec3 centre_line(const MovingPoints& q) { return q[0] - (q[1] + q[2] + q[3]) / 3.0; }
  static Vec3 perpendicular(const FourPoints& p) { return (p[2] - p[1]).cross(p[3] - p[1]); }
  static Vec3 normal(const FourPoints& p, const ClosestPair& c, const Vec3& s) {
    return contact_normal_vertex_face(p, c, s);
  }
};

struct EdgeEdge {
  using D = Differences<4>;
  static D differences(const MovingPoints& q) { return edge_edge_differences(q); }
  static ClosestPair closest(const FourPoints& p) { return closest_edge_edge(p); }
  static Vec3 centre_line(const MovingPoints& q) { return 0.5 * ((q[0] + q[1]) - (q[2] + q[3])); }
  static Vec3 perpendicular(const FourPoints& p) { return (p[1] - p[0]).cross(p[3] - p[2]); }
  static Vec3 normal(const FourPoints& p, const ClosestPair& c, const Vec3& s) {
    return contact_normal_edge_edge(p, c, s);
  }
};

// Returns the points at `time`, relative to the start position of the first point.
FourPoints at_time(const MovingPoints& q, double time) {
  FourPoints p;
  for (int i = 0; i < 4; ++i) p[i] = (1.0 - time) * (q[i] - q[0]) + time * (q[4 + i] - q[0]);
  return p;
}

template <class Kind, class FloorOf>
Impact test(const MovingPoints& q, double largest_floor, FloorOf&& floor_of) {
  const typename Kind::D differences = Kind::differences(q);
  // A plane perpendicular to the line between the centres of the features at the start often proves
  // separation without a search for closest points.
  const Vec3 line = Kind::centre_line(q);
  const double length = line.norm();
  if (length > 0.0 &&
      differences.advance(line / length, 0.0, largest_floor + differences.rounding) >= 1.0)
    return {};

  // A motion that is undecided after all passes, such as a grazing one, counts as an impact.
  constexpr int max_passes = 100;
  Impact impact;
  double time = 0.0, floor = 0.0;
  Vec3 side = Vec3::Zero();
  for (int pass = 0;; ++pass) {
    const FourPoints p = at_time(q, time);
    const ClosestPair closest = Kind::closest(p);
    if (pass == 0) {
      floor = floor_of(closest.distance) + differences.rounding;
      impact.start_distance = closest.distance;
      impact.touching = closest.distance <= floor;
      side = closest.difference;
    }
    double next = time;
    if (closest.distance > 0.0)
      next = differences.advance(closest.difference / closest.distance, time, floor);
    if (next < 1.0) {
      // In a tiny gap, the difference of the closest points suffers from cancellation. The
      // perpendicular of the face, or of both edges, is then a better normal of the plane.
      Vec3 perpendicular = Kind::perpendicular(p);
      const double perpendicular_length = perpendicular.norm();
      if (perpendicular_length > 0.0) {
        perpendicular /= perpendicular.dot(closest.difference) < 0.0 ? -perpendicular_length
                                                                     : perpendicular_length;
        next = std::max(next, differences.advance(perpendicular, time, floor));
      }
    }
    if (next >= 1.0) return {};
    const bool at_floor = closest.distance <= floor + 1e-3 * floor;
    if (!(next > time) || at_floor || pass == max_passes) {
      impact.hit = true;
      impact.time = time;
      impact.weights = closest.weights;
      impact.normal = Kind::normal(p, closest, side);
      return impact;
    }
    time = next;
  }
}

}  // namespace

double gap_floor(double start_distance, double largest) {
  if (start_distance > 2.0 * largest) return largest;
  return (start_distance > 0.01 * largest ? 0.5 : 0.9) * start_distance;
}

Impact continuous_vertex_face(const MovingPoints& points, double floor) {
  return test<VertexFace>(points, floor, [&](double) { return floor; });
}
Impact continuous_edge_edge(const MovingPoints& points, double floor) {
  return test<EdgeEdge>(points, floor, [&](double) { return floor; });
}
Impact continuous_vertex_face_above_gap(const MovingPoints& points, double largest_gap_floor) {
  return test<VertexFace>(points, largest_gap_floor, [&](double start_distance) {
    return gap_floor(start_distance, largest_gap_floor);
  });
}
Impact continuous_edge_edge_above_gap(const MovingPoints& points, double largest_gap_floor) {
  return test<EdgeEdge>(points, largest_gap_floor, [&](double start_distance) {
    return gap_floor(start_distance, largest_gap_floor);
  });
}

}  // namespace loomstone
