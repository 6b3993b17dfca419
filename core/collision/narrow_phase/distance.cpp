#include "core/collision/narrow_phase/distance.h"

#include <algorithm>
#include <cmath>

#include "core/base/halves.h"

namespace loomstone {

namespace {

// Returns the parameter in [0, 1] of the point closest to p on the segment from b to b + d. Returns
// 0 for a segment of zero length.
LOOMSTONE_INLINE double parameter_on_segment(const Vec3& p, const Vec3& b, const Vec3& d) {
  const double length2 = d.squaredNorm();
  if (!(length2 > 0.0)) return 0.0;
  return std::clamp((p - b).dot(d) / length2, 0.0, 1.0);
}

double size_of(const FourPoints& p) {
  double size = 0.0;
  for (int i = 1; i < 4; ++i) size = std::max(size, (p[i] - p[0]).cwiseAbs().maxCoeff());
  return size;
}

Vec3 normal_or(const FourPoints& points, const ClosestPair& closest, const Vec3& perpendicular,
               const Vec3& side) {
  if (closest.distance > 1e-14 * size_of(points)) return closest.difference / closest.distance;
  const double length = perpendicular.norm();
  if (length > 0.0) return perpendicular / (perpendicular.dot(side) < 0.0 ? -length : length);
  const double side_length = side.norm();
  return side_length > 0.0 ? Vec3(side / side_length) : Vec3(Vec3::UnitZ());
}

}  // namespace

ClosestPair closest_vertex_face(const FourPoints& points) {
  const Vec3 &p = points[0], &a = points[1], &b = points[2], &c = points[3];
  const Vec3 ab = b - a, ac = c - a, bc = c - b, ap = p - a, bp = p - b;
  const Vec3 n = ab.cross(ac);
  const double n2 = n.squaredNorm();
  // The interior solution is ill-conditioned for slivers (height below 1e-7 of the longest edge).
  // For slivers, the distance to the edges suffices.
  const double longest2 = std::max({ab.squaredNorm(), ac.squaredNorm(), bc.squaredNorm()});
  if (n2 > 1e-14 * longest2 * longest2) {
    const double weight_a = n.dot(bc.cross(bp)), weight_c = n.dot(ab.cross(ap)),
                 weight_b = n2 - weight_a - weight_c;
    if (weight_a >= 0.0 && weight_b >= 0.0 && weight_c >= 0.0) {
      const double height = n.dot(ap) / n2;
      return {{1.0, -weight_a / n2, -weight_b / n2, -weight_c / n2},
              height * n,
              std::abs(height) * std::sqrt(n2),
              true};
    }
  }
  ClosestPair best{};
  double best2 = INFINITY;
  for (int edge = 0; edge < 3; ++edge) {
    const int i = 1 + edge, j = 1 + (edge + 1) % 3;
    const Vec3 d = points[j] - points[i];
    const double t = parameter_on_segment(p, points[i], d);
    const Vec3 difference = (p - points[i]) - t * d;
    const double distance2 = difference.squaredNorm();
    if (distance2 < best2) {
      best2 = distance2;
      best.weights = {1.0, 0.0, 0.0, 0.0};
      best.weights[i] = -(1.0 - t);
      best.weights[j] = -t;
      best.difference = difference;
    }
  }
  best.distance = std::sqrt(best2);
  best.interior = false;
  return best;
}

ClosestPair closest_edge_edge(const FourPoints& points) {
  const Vec3 &a = points[0], &b = points[2];
  const Vec3 da = points[1] - a, db = points[3] - b, r = a - b;
  const double aa = da.squaredNorm(), bb = db.squaredNorm(), ab = da.dot(db), ra = r.dot(da),
               rb = r.dot(db);
  const double determinant = aa * bb - ab * ab;
  ClosestPair best{};
  double best2 = INFINITY;
  const auto take = [&](double s, double t, bool interior) LOOMSTONE_INLINE_LAMBDA {
    const Vec3 difference = r + s * da - t * db;
    const double distance2 = difference.squaredNorm();
    if (distance2 < best2) {
      best2 = distance2;
      best = {{1.0 - s, s, -(1.0 - t), -t}, difference, 0.0, interior};
    }
  };
  if (determinant > 0.0) {
    const double s = (ab * rb - bb * ra) / determinant, t = (aa * rb - ab * ra) / determinant;
    if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) take(s, t, true);
  }
  // End points are tested if there is no interior solution, or if the edges are nearly parallel.
  // For nearly parallel edges, the interior solution is ill-conditioned.
  if (best2 == INFINITY || determinant < 1e-6 * aa * bb) {
    take(0.0, parameter_on_segment(a, b, db), false);
    take(1.0, parameter_on_segment(points[1], b, db), false);
    take(parameter_on_segment(b, a, da), 0.0, false);
    take(parameter_on_segment(points[3], a, da), 1.0, false);
  }
  best.distance = std::sqrt(best2);
  return best;
}

double distance_within(bool vertex_face, const FourPoints& p, double reach) {
  const int n_a = vertex_face ? 1 : 2;
  Vec3 centre_a = p[0], centre_b = p[n_a];
  for (int i = 1; i < n_a; ++i) centre_a += p[i];
  for (int i = n_a + 1; i < 4; ++i) centre_b += p[i];
  centre_a /= n_a;
  centre_b /= 4 - n_a;
  const Vec3 line = centre_a - centre_b;
  double low = INFINITY, high = -INFINITY;
  for (int i = 0; i < n_a; ++i) low = std::min(low, line.dot(p[i] - centre_b));
  for (int i = n_a; i < 4; ++i) high = std::max(high, line.dot(p[i] - centre_b));
  const double gap = low - high;
  if (gap > 0.0 && gap * gap > reach * reach * line.squaredNorm()) return INFINITY;
  return vertex_face ? closest_vertex_face(p).distance : closest_edge_edge(p).distance;
}

Vec3 contact_normal_vertex_face(const FourPoints& points, const ClosestPair& closest,
                                const Vec3& side) {
  return normal_or(points, closest, (points[2] - points[1]).cross(points[3] - points[1]), side);
}

Vec3 contact_normal_edge_edge(const FourPoints& points, const ClosestPair& closest,
                              const Vec3& side) {
  return normal_or(points, closest, (points[1] - points[0]).cross(points[3] - points[2]), side);
}

}  // namespace loomstone
