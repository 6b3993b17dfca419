// Fields, gradients and potentials of loops, current sheets and cylinders at a block of points.
#pragma once

#include <cmath>

#include "core/magnetics/sources/axisymmetric_terms.h"
#include "core/magnetics/sources/source.h"

namespace loomstone {

inline constexpr double on_surface = 1e-12;  // distance that counts as zero [radii]

// Cylindrical coordinates. The distance rho from the axis, beyond = rho - 1 and the height z are in
// units of the radius. The cosine and sine are those of the azimuth, which is 0 on the axis.
template <class Lanes>
struct Cylindrical {
  Lanes rho, beyond, cosine, sine, z;
};

template <class Lanes>
LOOMSTONE_INLINE Cylindrical<Lanes> cylindrical(const double* points, Index n, Index i,
                                                double radius) {
  const double scale = 1.0 / radius;
  const Lanes x = lanes_load<Lanes>(points + i), y = lanes_load<Lanes>(points + n + i);
  const Lanes distance = lanes_sqrt(x * x + y * y);
  Cylindrical<Lanes> p;
  p.rho = distance * scale;
  p.beyond = (distance - radius) * scale;
  const MaskOf<Lanes> off = distance > 0.0;
  const Lanes inverse = 1.0 / lanes_select(off, distance, lanes_all<Lanes>(1.0));
  p.cosine = lanes_select(off, x * inverse, lanes_all<Lanes>(1.0));
  p.sine = y * inverse;
  p.z = lanes_load<Lanes>(points + 2 * n + i) * scale;
  return p;
}

// Symmetric tensor in the axes (rho, phi, z).
template <class Lanes>
struct CylindricalTensor {
  Lanes rr, rp, pp, rz, pz, zz;
};

// Stores a tensor in Cartesian axes: xx, xy, xz, yy, yz, zz.
template <class Lanes>
LOOMSTONE_INLINE void store_tensor(const Cylindrical<Lanes>& p, const CylindricalTensor<Lanes>& t,
                                   Index n, double* out) {
  const Lanes c = p.cosine, s = p.sine;
  lanes_store(out, c * c * t.rr - 2.0 * c * s * t.rp + s * s * t.pp);
  lanes_store(out + n, c * s * (t.rr - t.pp) + (c * c - s * s) * t.rp);
  lanes_store(out + 2 * n, c * t.rz - s * t.pz);
  lanes_store(out + 3 * n, s * s * t.rr + 2.0 * c * s * t.rp + c * c * t.pp);
  lanes_store(out + 4 * n, s * t.rz + c * t.pz);
  lanes_store(out + 5 * n, t.zz);
}

template <class Lanes>
LOOMSTONE_INLINE void loop_field(double radius, double strength, const double* points, Index n,
                                 double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Cylindrical<Lanes> p = cylindrical<Lanes>(points, n, i, radius);
    const LoopTerms<Lanes> t = loop_terms(p.rho, p.beyond, p.z);
    lanes_store(out + i, strength * t.br * p.cosine);
    lanes_store(out + n + i, strength * t.br * p.sine);
    lanes_store(out + 2 * n + i, strength * t.bz);
  }
}

template <class Lanes>
LOOMSTONE_INLINE void loop_gradient(double radius, double strength, const double* points, Index n,
                                    double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Cylindrical<Lanes> p = cylindrical<Lanes>(points, n, i, radius);
    const LoopTerms<Lanes> t = loop_terms(p.rho, p.beyond, p.z);
    CylindricalTensor<Lanes> g{};
    g.rr = strength * (-t.dz_bz - t.br_over_rho);
    g.pp = strength * t.br_over_rho;
    g.rz = strength * t.dz_br;
    g.zz = strength * t.dz_bz;
    store_tensor(p, g, n, out + i);
  }
}

// Current sheet around a cylinder. Points on the sheet count as outside the cylinder if `side` is
// 1, and as inside if `side` is -1.
struct Sheet {
  double radius, height, side;      // radius and height [m]
  double length = height / radius;  // in radii
};

template <class Lanes>
struct SheetPoint {
  Cylindrical<Lanes> p;
  Lanes beyond, z1, z0;  // rho - 1, and the heights above the lower and the upper end, in radii
  MaskOf<Lanes> inside;
};

template <class Lanes>
LOOMSTONE_INLINE SheetPoint<Lanes> sheet_point(const double* points, Index n, Index i,
                                               Sheet sheet) {
  SheetPoint<Lanes> s;
  s.p = cylindrical<Lanes>(points, n, i, sheet.radius);
  s.beyond = lanes_select(lanes_abs(s.p.beyond) < on_surface,
                          lanes_all<Lanes>(sheet.side * on_surface), s.p.beyond);
  const double half = 0.5 * sheet.length * sheet.radius, scale = 1.0 / sheet.radius;
  const Lanes z = lanes_load<Lanes>(points + 2 * n + i);
  s.z1 = (z + half) * scale;
  s.z0 = (z - half) * scale;
  s.inside = (s.beyond < 0.0) & (s.z1 > on_surface) & (s.z0 < -on_surface);
  return s;
}

// Field of a cylinder with polarization j: B if `jump` is 0, and mu0 H if `jump` is j. `jump` is
// subtracted inside the cylinder.
template <class Lanes>
LOOMSTONE_INLINE void cylinder_field(Sheet sheet, const double* j, const double* jump,
                                     const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const SheetPoint<Lanes> s = sheet_point<Lanes>(points, n, i, sheet);
    const Cylindrical<Lanes>& p = s.p;
    const SheetTerms<Lanes> t = sheet_terms(p.rho, s.beyond, s.z1, s.z0, sheet.length, false);
    const Lanes jr = j[0] * p.cosine + j[1] * p.sine, jp = j[1] * p.cosine - j[0] * p.sine;
    const Lanes hr = (t.t - t.bz) * jr + t.br * j[2], hp = -t.t * jp;
    const Lanes zero{};
    lanes_store(out + i, (hr * p.cosine - hp * p.sine) +
                             lanes_select(s.inside, lanes_all<Lanes>(j[0] - jump[0]), zero));
    lanes_store(out + n + i, (hr * p.sine + hp * p.cosine) +
                                 lanes_select(s.inside, lanes_all<Lanes>(j[1] - jump[1]), zero));
    lanes_store(out + 2 * n + i, (t.br * jr + t.bz * j[2]) +
                                     lanes_select(s.inside, lanes_all<Lanes>(-jump[2]), zero));
  }
}

template <class Lanes>
LOOMSTONE_INLINE void cylinder_gradient(Sheet sheet, const double* j, const double* points, Index n,
                                        double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const SheetPoint<Lanes> s = sheet_point<Lanes>(points, n, i, sheet);
    const Cylindrical<Lanes>& p = s.p;
    const SheetTerms<Lanes> t = sheet_terms(p.rho, s.beyond, s.z1, s.z0, sheet.length, true);
    const double scale = 1.0 / sheet.radius;
    const Lanes jr = scale * (j[0] * p.cosine + j[1] * p.sine),
                jp = scale * (j[1] * p.cosine - j[0] * p.sine);
    const double jz = scale * j[2];
    // Third derivatives of the potential Psi (axisymmetric.h): the component phi phi rho is w, and
    // phi phi z is b_rho / rho. The components rho z z and z z z follow from the loops at the ends
    // of the sheet, and the others from Laplace's equation.
    const Lanes rrz = -t.dz_bz - t.br_over_rho, rrr = -t.w - t.dz_br;
    CylindricalTensor<Lanes> g;
    g.rr = rrr * jr + rrz * jz;
    g.rp = t.w * jp;
    g.pp = t.w * jr + t.br_over_rho * jz;
    g.rz = rrz * jr + t.dz_br * jz;
    g.pz = t.br_over_rho * jp;
    g.zz = t.dz_br * jr + t.dz_bz * jz;
    store_tensor(p, g, n, out + i);
  }
}

// Returns the potential of a ring of radius 1 with unit charge per length, the integral of
// 1 / (4 pi distance).
template <class Lanes>
LOOMSTONE_INLINE Lanes ring_potential(const Lanes& rho, const Lanes& beyond, const Lanes& zeta) {
  const Lanes alpha2 = zeta * zeta + (rho + 1.0) * (rho + 1.0);
  const Lanes beta2 = lanes_max(zeta * zeta + beyond * beyond, lanes_all<Lanes>(1e-30));
  Lanes a[1] = {lanes_all<Lanes>(1.0)}, b[1] = {lanes_all<Lanes>(1.0)};
  elliptic<1>(lanes_sqrt(beta2 / alpha2), lanes_all<Lanes>(1.0), a, b);
  return a[0] / (pi * lanes_sqrt(alpha2));
}

template <class Lanes>
LOOMSTONE_INLINE void cylinder_potential(Sheet sheet, const double* j, const double* points,
                                         Index n, double* out) {
  // Below this rho, the leading term of side_r in rho is used. Its relative error is about rho^2.
  constexpr double axis = 1e-4;
  const Lanes zero{};
  for (Index i = 0; i < n; i += n_lanes) {
    const SheetPoint<Lanes> s = sheet_point<Lanes>(points, n, i, sheet);
    const Cylindrical<Lanes>& p = s.p;
    const SheetTerms<Lanes> t = sheet_terms(p.rho, s.beyond, s.z1, s.z0, sheet.length, false);
    const Lanes jr = sheet.radius * (j[0] * p.cosine + j[1] * p.sine);
    const double jz = sheet.radius * j[2];
    const Lanes z_field = t.bz - lanes_select(s.inside, lanes_all<Lanes>(1.0), zero);
    const Lanes along = p.rho * ((t.t - t.bz) * jr + t.br * jz) + p.z * (t.br * jr + z_field * jz);
    // The field of a unit charge density on both end faces is minus the sum of the contributions of
    // both ends of the current sheet. `below` and `above` cancel the jump of these contributions at
    // the side.
    const SheetEnd<Lanes> e1 = sheet_end(p.rho, s.beyond, s.z1),
                          e0 = sheet_end(p.rho, s.beyond, s.z0);
    const Lanes below =
                    lanes_select(s.z1 > on_surface, lanes_all<Lanes>(0.5), lanes_all<Lanes>(-0.5)),
                above =
                    lanes_select(s.z0 < -on_surface, lanes_all<Lanes>(-0.5), lanes_all<Lanes>(0.5));
    const Lanes ends_z = lanes_select(s.beyond < 0.0, below + above, zero) - e1.bz - e0.bz,
                ends_r = -e1.br - e0.br;
    // For a unit charge density on the side, the radial field times rho is
    // z1 ring1 - z0 ring0 - bz, where bz is the axial field of the current sheet.
    const Lanes ring1 = ring_potential(p.rho, s.beyond, s.z1),
                ring0 = ring_potential(p.rho, s.beyond, s.z0);
    const Lanes c1 = 1.0 / lanes_sqrt(1.0 + s.z1 * s.z1), c0 = 1.0 / lanes_sqrt(1.0 + s.z0 * s.z0);
    const MaskOf<Lanes> on_axis = p.rho < axis;
    const Lanes side_r = lanes_select(
        on_axis, 0.25 * p.rho * (s.z0 * c0 * c0 * c0 - s.z1 * c1 * c1 * c1),
        (s.z1 * ring1 - s.z0 * ring0 - t.bz) / lanes_select(on_axis, lanes_all<Lanes>(1.0), p.rho));
    const Lanes layer = jr * (side_r + 0.5 * sheet.length * ends_r) +
                        jz * (ring0 - ring1 + 0.5 * sheet.length * ends_z);
    lanes_store(out + i, layer - along);
  }
}

// Vector potential of a sheet, or of a loop if the height is 0. Only its azimuthal component is
// non-zero.
template <class Lanes>
LOOMSTONE_INLINE void vector_potential(Sheet sheet, double strength, const double* points, Index n,
                                       double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const SheetPoint<Lanes> s = sheet_point<Lanes>(points, n, i, sheet);
    Lanes along;
    if (sheet.length > 0.0)
      along =
          strength * s.p.rho * sheet_terms(s.p.rho, s.beyond, s.z1, s.z0, sheet.length, false).t;
    else
      along = -strength * sheet_end(s.p.rho, s.beyond, s.p.z).br;
    lanes_store(out + i, -s.p.sine * along);
    lanes_store(out + n + i, s.p.cosine * along);
    lanes_store(out + 2 * n + i, Lanes{});
  }
}

// Predicate for split_block(): true at points where loop_terms() or sheet_terms() uses the midpoint
// rule. `half` is half the height of the sheet, and 0 for a loop. Lengths are in [m].
struct Smooth {
  double radius, half;
  bool operator()(double x, double y, double z) const {
    const double rho = std::sqrt(x * x + y * y), sum = (rho + radius) * (rho + radius),
                 beyond = (rho - radius) * (rho - radius);
    const double z1 = (z + half) * (z + half), z0 = (z - half) * (z - half);
    return beyond > smooth * sum || (std::abs(z) > half && z1 + beyond > smooth * (z1 + sum) &&
                                     z0 + beyond > smooth * (z0 + sum));
  }
};

}  // namespace loomstone
