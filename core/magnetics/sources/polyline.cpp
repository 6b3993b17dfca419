// A segment with current I, edge vector l and vectors r0, r1 from its ends to the point contributes
//   B = mu0 I/4pi (l x r0) 2 (1/d0 + 1/d1) / ((d0 + d1)^2 - l^2)
// with d0 = |r0| and d1 = |r1|.
#include "core/magnetics/sources/polyline.h"

#include <cmath>

#include "core/base/message.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

namespace {

// Terms of one segment in the symbols at the top of this file: c = l x r0, i0 = 1/d0, i1 = 1/d1 and
// outer = 1 / ((d0 + d1)^2 - l^2), which is computed without cancellation near the wire.
template <class Lanes>
struct Segment {
  Lanes3<Lanes> r0, r1, c;
  Lanes i0, i1, outer;
  double l[3];
};

template <class Lanes>
LOOMSTONE_INLINE Segment<Lanes> segment(const Lanes3<Lanes>& p, const double* a, double nearest) {
  Segment<Lanes> s;
  for (int k = 0; k < 3; ++k) s.l[k] = a[3 + k] - a[k];
  const double length = __builtin_sqrt(s.l[0] * s.l[0] + s.l[1] * s.l[1] + s.l[2] * s.l[2]);
  s.r0 = {p.x - a[0], p.y - a[1], p.z - a[2]};
  s.r1 = {p.x - a[3], p.y - a[4], p.z - a[5]};
  const Lanes t0 = (s.l[0] * s.r0.x + s.l[1] * s.r0.y + s.l[2] * s.r0.z) / length;
  const Lanes t1 = (s.l[0] * s.r1.x + s.l[1] * s.r1.y + s.l[2] * s.r1.z) / length;
  const MaskOf<Lanes> first = lanes_abs(t0) < lanes_abs(t1);
  const Lanes3<Lanes> r = {lanes_select(first, s.r0.x, s.r1.x), lanes_select(first, s.r0.y, s.r1.y),
                           lanes_select(first, s.r0.z, s.r1.z)};
  s.c = {s.l[1] * r.z - s.l[2] * r.y, s.l[2] * r.x - s.l[0] * r.z, s.l[0] * r.y - s.l[1] * r.x};
  const Lanes square =
      lanes_max(dot(s.c, s.c) / (length * length), lanes_all<Lanes>(nearest * nearest));
  const Lanes d0 = lanes_sqrt(t0 * t0 + square), d1 = lanes_sqrt(t1 * t1 + square);
  const Lanes beyond =
      lanes_select(t0 * t1 > 0.0, lanes_min(lanes_abs(t0), lanes_abs(t1)), Lanes{});
  const Lanes defect =
      square * (1.0 / (d0 + lanes_abs(t0)) + 1.0 / (d1 + lanes_abs(t1))) + 2.0 * beyond;
  s.i0 = 1.0 / d0;
  s.i1 = 1.0 / d1;
  s.outer = 1.0 / ((d0 + d1 + length) * defect);
  return s;
}

struct Wire {
  const double* vertices;
  Index segments;
  double scale;    // mu0 I / 2 pi [T m]
  double nearest;  // lower bound of the distance from the wire in the denominators [m]
};

template <class Lanes>
LOOMSTONE_INLINE void field_kernel(Wire wire, const double* points, Index n, double* out) {
  const auto [vertices, segments, scale, nearest] = wire;
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes3<Lanes> b{};
    for (Index k = 0; k < segments; ++k) {
      const Segment<Lanes> s = segment(p, vertices + 3 * k, nearest);
      const Lanes factor = (s.i0 + s.i1) * s.outer;
      b.x += factor * s.c.x;
      b.y += factor * s.c.y;
      b.z += factor * s.c.z;
    }
    lanes_store(out + i, scale * b.x);
    lanes_store(out + n + i, scale * b.y);
    lanes_store(out + 2 * n + i, scale * b.z);
  }
}

template <class Lanes>
LOOMSTONE_INLINE void gradient_kernel(Wire wire, const double* points, Index n, double* out) {
  const auto [vertices, segments, scale, nearest] = wire;
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes g[6];
    for (Lanes& each : g) each = Lanes{};
    for (Index k = 0; k < segments; ++k) {
      const Segment<Lanes> s = segment(p, vertices + 3 * k, nearest);
      // The field is Wire::scale times the sum of f c over the segments, where
      // f = (1/d0 + 1/d1) outer in the symbols of Segment. With n0 = r0/d0 and n1 = r1/d1,
      //   grad f = -outer (n0/d0^2 + n1/d1^2) - 2 f outer (d0 + d1)(n0 + n1).
      const Lanes f = (s.i0 + s.i1) * s.outer;
      const Lanes sum = 1.0 / s.i0 + 1.0 / s.i1;
      const Lanes a0 = -s.i0 * (s.outer * s.i0 * s.i0 + 2.0 * f * s.outer * sum);
      const Lanes a1 = -s.i1 * (s.outer * s.i1 * s.i1 + 2.0 * f * s.outer * sum);
      const Lanes dx = a0 * s.r0.x + a1 * s.r1.x, dy = a0 * s.r0.y + a1 * s.r1.y,
                  dz = a0 * s.r0.z + a1 * s.r1.z;
      // The gradient of f c has the components c_i f_,j + f c_i,j, where ,j is the derivative along
      // axis j. The sum of these gradients over a closed line is symmetric. Because c_i,j is
      // antisymmetric, only the symmetric part of c_i f_,j is added.
      g[0] += s.c.x * dx;
      g[1] += 0.5 * (s.c.x * dy + s.c.y * dx);
      g[2] += 0.5 * (s.c.x * dz + s.c.z * dx);
      g[3] += s.c.y * dy;
      g[4] += 0.5 * (s.c.y * dz + s.c.z * dy);
      g[5] += s.c.z * dz;
    }
    for (int c = 0; c < 6; ++c) lanes_store(out + c * n + i, scale * g[c]);
  }
}

}  // namespace

Polyline::Polyline(Points vertices, double current)
    : vertices_(std::move(vertices)), current_(current) {
  check_points(vertices_, "vertices");
  if (vertices_.rows() < 2)
    fail<InvalidInput>("vertices must be at least two points, got {}", vertices_.rows());
  if (!std::isfinite(current)) fail<InvalidInput>("current must be finite [A], got {}", current);
  radius_ = vertices_.rowwise().norm().maxCoeff();
  const Eigen::Index last = vertices_.rows() - 1;
  if (last > 1 && (vertices_.row(last) - vertices_.row(0)).norm() <= 1e-12 * radius_)
    vertices_.row(last) = vertices_.row(0);
  for (Eigen::Index i = 0; i < last; ++i)
    if (vertices_.row(i) == vertices_.row(i + 1))
      fail<InvalidInput>(
          "vertices must differ from one to the next, but rows {} and {} are the same; leave one "
          "out",
          i, i + 1);
}

void Polyline::field_block(const double* points, Index n, Quantity, double* field) const {
  const Wire wire{vertices_.data(), static_cast<Index>(vertices_.rows()) - 1,
                  mu0 * current_ / (2.0 * pi), 1e-15 * radius_};
  LOOMSTONE_WIDEST(field_kernel)(wire, points, n, field);
}

void Polyline::gradient_block(const double* points, Index n, double* gradient) const {
  if (!closed())
    throw InvalidInput(
        "vertices must form a closed line to have a gradient, got ends that differ; repeat the "
        "first vertex last");
  const Wire wire{vertices_.data(), static_cast<Index>(vertices_.rows()) - 1,
                  mu0 * current_ / (2.0 * pi), 1e-15 * radius_};
  LOOMSTONE_WIDEST(gradient_kernel)(wire, points, n, gradient);
}

Vec3 Polyline::moment() const {
  Vec3 sum = Vec3::Zero();
  for (Eigen::Index i = 0; i + 1 < vertices_.rows(); ++i) {
    const Vec3 a = vertices_.row(i).transpose(), b = vertices_.row(i + 1).transpose();
    sum += a.cross(b);
  }
  return 0.5 * current_ * sum;
}

std::vector<Panel> Polyline::panels() const {
  std::vector<Panel> panels;
  for (Eigen::Index i = 0; i + 1 < vertices_.rows(); ++i) {
    Panel p{Panel::Shape::segment};
    p.a = vertices_.row(i).transpose();
    p.b = (vertices_.row(i + 1) - vertices_.row(i)).transpose();
    p.current = current_;
    panels.push_back(p);
  }
  return panels;
}

}  // namespace loomstone
