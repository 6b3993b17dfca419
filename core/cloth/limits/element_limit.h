// Strain limiting of one triangle: the polar decomposition F = R U of the 3x2 deformation gradient
// in closed form, the strain U - I, and the correction that reaches a target strain and conserves
// linear and angular momentum. Implements [Thomaszewski2010] 3.3.1, (3.2)-(3.14). The code is
// written once for one triangle (Real = double) and for eight triangles (Real = Lanes of
// core/base/simd.h).
//
// The 6x6 system (3.10) for the displacements of the corners is solved without an inverse. Its
// strain equations require displacements R (E + w J) X. Here E = target - strain (symmetric 2x2), J
// is the rotation by 90 degrees, X is the rest position of a corner relative to the centre of mass
// of the three corners, and the scalar w is unknown. Because X is relative to this centre, linear
// momentum is conserved. Conservation of angular momentum about the centre determines w from the
// constant moments M = sum m X X^T, where m are the masses of the corners:
//     w = -[(U M E)_12 - (U M E)_21] / tr(U M).
// In the plane, this solution takes 22 multiplications, 16 additions and 1 division. The thesis
// counts 37, 33 and 1 (3.13). The 5x5 inverse of the thesis does not exist for a triangle whose
// third corner lies above the midpoint of its base.
//
// A held corner does not move. With one held corner, this corner has infinite mass and replaces the
// centre of mass, so w conserves angular momentum about it. The remaining equations, three of
// strain and one of angular momentum, are solved exactly. With two held corners, the displacement
// of the free corner has only two unknown components, which are chosen to fit the target strain in
// the least-squares sense. The displacement is again R (E + w J) X, where X is the height vector
// from the held edge to the free corner. This departs from (3.15), whose result depends on the unit
// of mass. With three held corners, nothing moves.
//
// In space, the 3x2 matrix F has no determinant whose sign could show that a triangle is inverted.
// U is therefore always positive semi-definite, and an inverted triangle counts as a rotated one.
// If the columns of F are parallel (rank one), the plane of the triangle is unknown, and an
// arbitrary normal is chosen. If all corners coincide (F = 0), R is zero and no corner moves. None
// of these cases yields NaN.
#pragma once

#include <cmath>

#include "core/base/simd.h"
#include "core/base/types.h"

namespace loomstone::limit {

LOOMSTONE_INLINE double root(double a) { return std::sqrt(a); }
template <class Lanes>
LOOMSTONE_INLINE Lanes root(const Lanes& a) {
  return lanes_sqrt(a);
}
LOOMSTONE_INLINE double greater(double a, double b) { return a > b ? a : b; }
template <class Lanes>
LOOMSTONE_INLINE Lanes greater(const Lanes& a, const Lanes& b) {
  return lanes_max(a, b);
}
LOOMSTONE_INLINE double smaller(double a, double b) { return a < b ? a : b; }
template <class Lanes>
LOOMSTONE_INLINE Lanes smaller(const Lanes& a, const Lanes& b) {
  return lanes_min(a, b);
}
template <class Real>
LOOMSTONE_INLINE Real size(const Real& a) {
  return greater(a, -a);
}
LOOMSTONE_INLINE double largest(double a) { return a; }
template <class Lanes>
LOOMSTONE_INLINE double largest(const Lanes& a) {
  const Lanes b = greater(a, lanes_shuffle<4, 5, 6, 7, 0, 1, 2, 3>(a, a));
  const Lanes c = greater(b, lanes_shuffle<2, 3, 0, 1, 6, 7, 4, 5>(b, b));
  return c[0] > c[1] ? c[0] : c[1];
}
LOOMSTONE_INLINE double at(double a, int) { return a; }
template <class Lanes>
LOOMSTONE_INLINE double at(const Lanes& a, int lane) {
  return a[lane];
}
LOOMSTONE_INLINE void put(double& a, int, double value) { a = value; }
template <class Lanes>
LOOMSTONE_INLINE void put(Lanes& a, int lane, double value) {
  lanes_put(a, lane, value);
}
template <class Real>
inline constexpr int width = sizeof(Real) / sizeof(double);

template <class Real>
struct Space {
  Real x, y, z;
};
template <class Real>
LOOMSTONE_INLINE Space<Real> minus(const Space<Real>& a, const Space<Real>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
LOOMSTONE_INLINE Space<Real> combine(const Space<Real>& a, const Real& s, const Space<Real>& b,
                                     const Real& t) {
  return {a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t};
}
template <class Real>
LOOMSTONE_INLINE Real dot(const Space<Real>& a, const Space<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
LOOMSTONE_INLINE Space<Real> cross(const Space<Real>& a, const Space<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Symmetric 2x2 matrix: strain (weft, warp, shear e12), moments, or U.
template <class Real>
struct Symmetric {
  Real a11, a22, a12;
};

// Constants of one triangle, or of eight triangles in SIMD lanes.
template <class Real>
struct Element {
  Real g0x, g0y, g1x, g1y;      // gradients of the shape functions of corners 0 and 1 [1/m]
  Real x0, y0, x1, y1, x2, y2;  // X of each corner (see the top of this file), 0 if held [m]
  // Sum over free corners of mass times X X^T, up to a positive factor, which has no influence. If
  // two corners are held, it is instead h h^T [m^2] with the height vector h over the held edge.
  Symmetric<Real> moments;
};
// Number of values in an Element, and number of those that are gradients. The gradients come first.
inline constexpr int element_numbers = 13, element_gradients = 4;

// Polar decomposition F = R U: F, U and their invariants. rotation() computes R from them.
template <class Real>
struct Polar {
  Space<Real> f1, f2, normal;  // columns of F; normal = f1 x f2
  Real d, s;                   // d = sqrt(det C), s = tr U, with C = F^T F
  Symmetric<Real> u;
};

// Columns of F = sum_i x_i (grad N_i)^T (2.31) with the shape functions N_i. The gradients sum to
// zero, so it suffices to use positions relative to corner 2.
template <class Real>
LOOMSTONE_INLINE void columns(const Element<Real>& e, const Space<Real>& p0, const Space<Real>& p1,
                              const Space<Real>& p2, Space<Real>& f1, Space<Real>& f2) {
  const Space<Real> a = minus(p0, p2), b = minus(p1, p2);
  f1 = combine(a, e.g0x, b, e.g1x);
  f2 = combine(a, e.g0y, b, e.g1y);
}

// U = (C + d I) / sqrt(tr C + 2 d) with C = F^T F, d = sqrt(det C).
template <class Real>
LOOMSTONE_INLINE Polar<Real> stretch(const Element<Real>& e, const Space<Real>& p0,
                                     const Space<Real>& p1, const Space<Real>& p2) {
  Polar<Real> p;
  columns(e, p0, p1, p2, p.f1, p.f2);
  const Real c11 = dot(p.f1, p.f1), c22 = dot(p.f2, p.f2), c12 = dot(p.f1, p.f2);
  p.normal = cross(p.f1, p.f2);
  p.d = root(dot(p.normal, p.normal));
  p.s = root(c11 + c22 + 2.0 * p.d);
  const Real inverse = 1.0 / (p.s + 1e-300);
  p.u = {(c11 + p.d) * inverse, (c22 + p.d) * inverse, c12 * inverse};
  return p;
}

// R = (F + cof F) / tr U with cof F = (f2 x n, n x f1), where f1 and f2 are the columns of F and n
// is the unit normal. If f1 and f2 are nearly parallel, n is any unit vector normal to the longer
// one.
template <class Real>
LOOMSTONE_INLINE void rotation(const Polar<Real>& p, Space<Real>& r1, Space<Real>& r2) {
  Space<Real> n = p.normal;
  const Real length = p.d + 1e-300;
  n = {n.x / length, n.y / length, n.z / length};
  const Real flat = 1e-12 * (p.s * p.s);
  if (largest(flat - p.d) >= 0.0)
    for (int l = 0; l < width<Real>; ++l) {
      if (at(p.d, l) > at(flat, l)) continue;
      Vec3 a(at(p.f1.x, l), at(p.f1.y, l), at(p.f1.z, l));
      const Vec3 b(at(p.f2.x, l), at(p.f2.y, l), at(p.f2.z, l));
      if (b.squaredNorm() > a.squaredNorm()) a = b;
      Index least = 0;
      a.cwiseAbs().minCoeff(&least);
      const Vec3 any = a.cross(Vec3::Unit(least)).stableNormalized();  // zero if a is zero
      put(n.x, l, any.x()), put(n.y, l, any.y()), put(n.z, l, any.z());
    }
  const Real inverse = 1.0 / (p.s + 1e-300);
  const Space<Real> c1 = cross(p.f2, n), c2 = cross(n, p.f1);
  r1 = {(p.f1.x + c1.x) * inverse, (p.f1.y + c1.y) * inverse, (p.f1.z + c1.z) * inverse};
  r2 = {(p.f2.x + c2.x) * inverse, (p.f2.y + c2.y) * inverse, (p.f2.z + c2.z) * inverse};
}

// Smallest and largest admissible strain or strain rate.
struct Bounds {
  double low[3], high[3];  // weft, warp, shear
};

// Target minus strain (3.4): the correction that returns a strain to its bounds. It is zero within
// the bounds.
template <class Real>
LOOMSTONE_INLINE Symmetric<Real> excess(const Bounds& b, const Symmetric<Real>& strain) {
  const auto back = [&](int k, const Real& e) LOOMSTONE_INLINE_LAMBDA -> Real {
    const Real low = Real{} + b.low[k], high = Real{} + b.high[k];
    return greater(low, smaller(high, e)) - e;
  };
  return {back(0, strain.a11), back(1, strain.a22), back(2, strain.a12)};
}

// Returns w such that the displacement R (E + w J) X conserves angular momentum. `m` contains the
// moments M, `u` the stretch U, and `e` is E (symbols as at the top of this file).
template <class Real>
LOOMSTONE_INLINE Real spin(const Symmetric<Real>& m, const Symmetric<Real>& u,
                           const Symmetric<Real>& e) {
  const Real shared = u.a12 * m.a12;
  const Real um11 = u.a11 * m.a11 + shared, um12 = u.a11 * m.a12 + u.a12 * m.a22;
  const Real um21 = u.a12 * m.a11 + u.a22 * m.a12, um22 = shared + u.a22 * m.a22;
  const Real q = (um11 - um22) * e.a12 + um12 * e.a22 - um21 * e.a11;
  return q / (-1e-300 - (um11 + um22));
}

// Returns w = (h x E h) / |h|^2, which fits the target strain in the least-squares sense if two
// corners are held. h is the height vector over the held edge, `m` is h h^T, and `e` is E (see the
// top of this file).
template <class Real>
LOOMSTONE_INLINE Real spin_of_two(const Symmetric<Real>& m, const Symmetric<Real>& e) {
  return ((m.a11 - m.a22) * e.a12 + m.a12 * (e.a22 - e.a11)) / (m.a11 + m.a22 + 1e-300);
}
// Returns the size of the part of E that can be corrected while two corners are held. It is the
// larger of the magnitudes of two components of E h / |h|: the one along h and the one
// perpendicular to h (symbols of spin_of_two()).
template <class Real>
LOOMSTONE_INLINE Real reach_of_two(const Symmetric<Real>& m, const Symmetric<Real>& e) {
  const Real along =
      (m.a11 * e.a11 + 2.0 * (m.a12 * e.a12) + m.a22 * e.a22) / (m.a11 + m.a22 + 1e-300);
  return greater(size(along), size(spin_of_two(m, e)));
}

// Computes the columns g1 and g2 of R (E + w J), where J is the rotation by 90 degrees. A corner
// moves by g1 X_x + g2 X_y, with X as defined at the top of this file.
template <class Real>
LOOMSTONE_INLINE void field(const Space<Real>& r1, const Space<Real>& r2, const Symmetric<Real>& e,
                            const Real& w, Space<Real>& g1, Space<Real>& g2) {
  g1 = combine(r1, e.a11, r2, e.a12 + w);
  g2 = combine(r1, e.a12 - w, r2, e.a22);
}

}  // namespace loomstone::limit
