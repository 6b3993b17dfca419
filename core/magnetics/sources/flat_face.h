// Field of a flat face with uniform charge, from logarithms for its straight edges [Wilton1984] and
// the solid angle of a triangle [VanOosteromStrackee1983]. The template parameter T selects between
// one face at eight points (T is double) and eight faces at one point (T is a lane vector).
#pragma once

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

// Smallest distances from the plane of a face and from the line of an edge at which fields are
// evaluated, in radii of the body. Closer points are evaluated at these distances.
inline constexpr double on_face = 1e-12, on_edge = 1e-15;

// Terms of a straight edge, which contributes the logarithm of sum / defect to the field of a face.
// `sum` and `defect` are computed without cancellation on and near the line of the edge.
template <class Lanes>
struct EdgeTerms {
  Lanes3<Lanes> r0, r1;  // vectors from the two ends to the point
  Lanes d0, d1;          // lengths of r0 and r1
  Lanes sum, defect;     // d0 + d1 + l and d0 + d1 - l, where l is the edge length
};

template <class Lanes, class T>
LOOMSTONE_INLINE EdgeTerms<Lanes> edge_terms(const Lanes3<Lanes>& p, const T* e, double nearest) {
  EdgeTerms<Lanes> t;
  t.r0 = {p.x - e[0], p.y - e[1], p.z - e[2]};
  t.r1 = {p.x - e[3], p.y - e[4], p.z - e[5]};
  const T l = e[6], inverse = 1.0 / l, ux = (e[3] - e[0]) * inverse, uy = (e[4] - e[1]) * inverse,
          uz = (e[5] - e[2]) * inverse;
  // t0 and t1 are the coordinates of the point along the edge, relative to the two ends. `square`
  // is the squared distance of the point from the line of the edge, but at least nearest^2. It is
  // computed from the nearer end.
  const Lanes t0 = ux * t.r0.x + uy * t.r0.y + uz * t.r0.z;
  const Lanes t1 = ux * t.r1.x + uy * t.r1.y + uz * t.r1.z;
  const MaskOf<Lanes> first = lanes_abs(t0) < lanes_abs(t1);
  const Lanes3<Lanes> r = {lanes_select(first, t.r0.x, t.r1.x), lanes_select(first, t.r0.y, t.r1.y),
                           lanes_select(first, t.r0.z, t.r1.z)};
  const Lanes3<Lanes> c = {uy * r.z - uz * r.y, uz * r.x - ux * r.z, ux * r.y - uy * r.x};
  const Lanes square = lanes_max(dot(c, c), lanes_all<Lanes>(nearest * nearest));
  t.d0 = lanes_sqrt(t0 * t0 + square);
  t.d1 = lanes_sqrt(t1 * t1 + square);
  const Lanes beyond =
      lanes_select(t0 * t1 > 0.0, lanes_min(lanes_abs(t0), lanes_abs(t1)), Lanes{});
  t.sum = t.d0 + t.d1 + l;
  const Lanes a = t.d0 + lanes_abs(t0), b = t.d1 + lanes_abs(t1);
  t.defect = square * (a + b) / (a * b) + 2.0 * beyond;
  return t;
}

// Gradients of an edge's logarithm and of the edge's contribution to the solid angle of a face. The
// gradient of this contribution is proportional to the field of a current along the edge.
template <class Lanes>
struct EdgeGradients {
  Lanes3<Lanes> log, angle;
};

template <class Lanes, class T>
LOOMSTONE_INLINE EdgeGradients<Lanes> edge_gradients(const EdgeTerms<Lanes>& t, const T* e) {
  const T l = e[6], lx = e[3] - e[0], ly = e[4] - e[1], lz = e[5] - e[2];
  const Lanes i0 = 1.0 / t.d0, i1 = 1.0 / t.d1;
  const Lanes outer = 1.0 / (t.sum * t.defect);  // 1 / ((d0 + d1)^2 - l^2)
  // Let s be the vector along the edge and l its length. The gradient of the logarithm is
  // -2 l (r0/d0 + r1/d1) / ((d0 + d1)^2 - l^2). That of the contribution to the solid angle is
  // -2 (s x r0) (1/d0 + 1/d1) / ((d0 + d1)^2 - l^2).
  const Lanes a = -2.0 * l * outer, b = -2.0 * (i0 + i1) * outer;
  return {{a * (t.r0.x * i0 + t.r1.x * i1), a * (t.r0.y * i0 + t.r1.y * i1),
           a * (t.r0.z * i0 + t.r1.z * i1)},
          {b * (ly * t.r0.z - lz * t.r0.y), b * (lz * t.r0.x - lx * t.r0.z),
           b * (lx * t.r0.y - ly * t.r0.x)}};
}

// Adds the contribution of an edge to the gradient xx, xy, xz, yy, yz, zz of a face's field.
// `outward` is the normal of the edge in the plane of the face, and `normal` is the face normal. A
// Polyhedron passes the sums of both over the faces at the edge, weighted by charge.
template <class Lanes, class T>
LOOMSTONE_INLINE void add_edge_gradients(const EdgeGradients<Lanes>& d, const T* outward,
                                         const T* normal, Lanes* g) {
  g[0] += outward[0] * d.log.x + normal[0] * d.angle.x;
  g[1] += 0.5 * (outward[0] * d.log.y + outward[1] * d.log.x + normal[0] * d.angle.y +
                 normal[1] * d.angle.x);
  g[2] += 0.5 * (outward[0] * d.log.z + outward[2] * d.log.x + normal[0] * d.angle.z +
                 normal[2] * d.angle.x);
  g[3] += outward[1] * d.log.y + normal[1] * d.angle.y;
  g[4] += 0.5 * (outward[1] * d.log.z + outward[2] * d.log.y + normal[1] * d.angle.z +
                 normal[2] * d.angle.y);
  g[5] += outward[2] * d.log.z + normal[2] * d.angle.z;
}

// Returns the solid angle of a triangle seen from p [VanOosteromStrackee1983]. It is positive if p
// is on the side to which the normal points. f contains the triangle's three corners, its unit
// normal and twice its area.
template <class Lanes, class T>
LOOMSTONE_INLINE Lanes solid_angle(const Lanes3<Lanes>& p, const T* f, double nearest) {
  const Lanes3<Lanes> a = {p.x - f[0], p.y - f[1], p.z - f[2]},
                      b = {p.x - f[3], p.y - f[4], p.z - f[5]},
                      c = {p.x - f[6], p.y - f[7], p.z - f[8]};
  const Lanes da = norm(a), db = norm(b), dc = norm(c);
  // The height above the plane is measured from the nearest corner, where rounding is smallest.
  Lanes height = f[9] * a.x + f[10] * a.y + f[11] * a.z;
  const Lanes from_b = f[9] * b.x + f[10] * b.y + f[11] * b.z,
              from_c = f[9] * c.x + f[10] * c.y + f[11] * c.z;
  height = lanes_select(dc < da, from_c, height);
  height = lanes_select(db < lanes_min(da, dc), from_b, height);
  height = lanes_select(lanes_abs(height) < nearest, lanes_all<Lanes>(nearest), height);
  const Lanes below = da * db * dc + dot(a, b) * dc + dot(a, c) * db + dot(b, c) * da;
  return 2.0 * lanes_atan2(height * f[12], below);
}

}  // namespace loomstone
