// Two features a and b touch when the set of differences a - b of their points contains the origin.
// This set is a triangle for a vertex and a face, and a parallelogram for two edges. Its corners
// move linearly. The corners are coplanar with the origin when a cubic vanishes. At such a time,
// the set contains the origin if certain quadratics agree in sign (see Inside).
#include "core/collision/narrow_phase/exact_continuous.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "core/collision/narrow_phase/float_continuous.h"
#include "core/collision/narrow_phase/polynomial.h"

namespace loomstone {

namespace {

using Curve = std::array<Polynomial, 3>;  // coordinates as functions of time

Curve operator-(const Curve& a, const Curve& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Curve cross(const Curve& a, const Curve& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Polynomial dot(const Curve& a, const Curve& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// x = mantissa * 2^exponent with an odd mantissa; for x = 0, the mantissa is 0.
struct Binary {
  std::int64_t mantissa = 0;
  int exponent = std::numeric_limits<int>::max();

  explicit Binary(double x) {
    if (x == 0.0) return;
    exponent = std::ilogb(x) - (std::numeric_limits<double>::digits - 1);
    mantissa = static_cast<std::int64_t>(std::ldexp(x, -exponent));
    const int zeros = __builtin_ctzll(static_cast<std::uint64_t>(mantissa));
    mantissa >>= zeros;
    exponent += zeros;
  }
};

// Returns the moving points as polynomials of time, scaled to integers by a common power of two.
std::array<Curve, 4> integer_points(const MovingPoints& q) {
  int least = std::numeric_limits<int>::max();
  for (const Vec3& point : q)
    for (int k = 0; k < 3; ++k) least = std::min(least, Binary(point[k]).exponent);
  const auto integer = [&](double x) {
    const Binary binary(x);
    return Integer(binary.mantissa)
        .shifted(x == 0.0 ? 0u : static_cast<unsigned>(binary.exponent - least));
  };
  std::array<Curve, 4> points;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) points[i][k].c = {integer(q[i][k]), integer(q[4 + i][k])};
  return points;
}

// Decides whether the triangle or parallelogram of the differences a - b contains the origin at a
// time when the origin lies in its plane.
struct Inside {
  // One vector per side, perpendicular to the plane. If a coordinate is positive in one vector and
  // negative in another, the origin is outside. If a coordinate has only one of these signs, apart
  // from zeros, the origin is inside.
  std::vector<Curve> sides;
  // If all `sides` vanish, the corners lie on one line through the origin. The origin is then
  // inside unless some coordinate has the same strict sign for all corners.
  std::vector<Curve> corners;

  bool operator()(const AlgebraicTime& time) const {
    for (int k = 0; k < 3; ++k) {
      bool positive = false, negative = false;
      for (const Curve& side : sides) {
        const int sign = time.sign_of(side[k]);
        positive = positive || sign > 0;
        negative = negative || sign < 0;
        if (positive && negative) return false;
      }
      if (positive || negative) return true;
    }
    for (int k = 0; k < 3; ++k) {
      bool low = true, high = true;
      for (const Curve& corner : corners) {
        const int sign = time.sign_of(corner[k]);
        low = low && sign < 0;
        high = high && sign > 0;
      }
      if (low || high) return false;
    }
    return true;
  }

  // Returns whether the triangle or parallelogram contains the origin at any time, given that the
  // origin lies in its plane at all times. It suffices to test the start, the end, and the roots of
  // all coordinates of `sides` and `corners`, because signs change only at these roots and the
  // times of contact form a closed set.
  bool ever() const {
    if ((*this)(AlgebraicTime::start()) || (*this)(AlgebraicTime::end())) return true;
    for (const auto* curves : {&sides, &corners})
      for (const Curve& curve : *curves)
        for (const Polynomial& p : curve)
          if (!p.zero() && any_root(p, *this)) return true;
    return false;
  }
};

bool meet(const Polynomial& volume, const Inside& inside) {
  return volume.zero() ? inside.ever() : any_root(volume, inside);
}

}  // namespace

bool exactly_meet_vertex_face(const MovingPoints& points) {
  const std::array<Curve, 4> p = integer_points(points);
  const std::vector<Curve> d = {p[0] - p[1], p[0] - p[2], p[0] - p[3]};
  const Inside inside{{cross(d[0], d[1]), cross(d[1], d[2]), cross(d[2], d[0])}, d};
  return meet(dot(d[2], inside.sides[0]), inside);
}

bool exactly_meet_edge_edge(const MovingPoints& points) {
  const std::array<Curve, 4> p = integer_points(points);
  const Curve a = p[1] - p[0], b = p[3] - p[2], w = p[0] - p[2], wa = p[1] - p[2], wb = p[0] - p[3];
  // The lines of the edges meet where w + s a - t b = 0. This gives s = (b x w) / (a x b) and
  // t = (a x w) / (a x b). The vectors of the four sides are the numerators of s, 1 - s, t, 1 - t.
  const Inside inside{{cross(b, w), cross(wa, b), cross(a, w), cross(wb, a)},
                      {w, wa, wb, p[1] - p[3]}};
  return meet(dot(w, cross(a, b)), inside);
}

ExactImpact exact_continuous_vertex_face(const MovingPoints& points) {
  const Decision decision = decide_vertex_face(points);
  const bool hit = decision.proof == Proof::Meet ||
                   (decision.proof == Proof::Open && exactly_meet_vertex_face(points));
  return hit ? ExactImpact{true, decision.time} : ExactImpact{};
}

ExactImpact exact_continuous_edge_edge(const MovingPoints& points) {
  const Decision decision = decide_edge_edge(points);
  const bool hit = decision.proof == Proof::Meet ||
                   (decision.proof == Proof::Open && exactly_meet_edge_edge(points));
  return hit ? ExactImpact{true, decision.time} : ExactImpact{};
}

}  // namespace loomstone
