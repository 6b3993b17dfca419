// Fields of a loop (mu0 I = 1) and of a cylindrical current sheet (mu0 K = 1) of radius 1 about the
// z axis; see axisymmetric.h. rho is the distance of the point from the axis. zeta is its height
// above the loop, or above an end of the sheet. phi is the azimuth of a wire element minus that of
// the point. The integration variable is theta = (pi - phi) / 2. With c = cos^2 theta and
// s = sin^2 theta,
//   cos phi = s - c,   sin^2 phi = 4 s c,   D^2 = zeta^2 + (rho+1)^2 c + (rho-1)^2 s,
// where D is the distance from the point to the wire element. The integrals use the midpoint rule
// where it is accurate (see `smooth`). Elsewhere, they are elliptic integrals with
// Delta^2 = c + kc^2 s, where kc is the complementary modulus.
#pragma once

#include "core/magnetics/sources/elliptic.h"

namespace loomstone {

inline constexpr int n_azimuths = 12;
// Squared complementary modulus above which the midpoint rule is used. For a sheet, the least value
// over the height of the sheet counts. The relative error of the rule is then at most of the order
// of ((1 - kc) / (1 + kc))^(2 n_azimuths) = 0.172^24 = 4e-19.
inline constexpr double smooth = 0.5;

struct Azimuths {
  double c[n_azimuths], s[n_azimuths];
};
extern const Azimuths azimuths;

template <class Lanes>
struct LoopTerms {
  Lanes bz, br, br_over_rho;  // field components
  Lanes dz_bz, dz_br;         // derivatives along z
};

template <class Lanes>
struct SheetTerms {
  Lanes bz, br, br_over_rho, t;  // t = A_phi / rho
  Lanes dz_bz, dz_br, w;         // w: minus the derivative of t along rho
};

template <class Lanes>
LOOMSTONE_INLINE void take(const MaskOf<Lanes>& where, LoopTerms<Lanes>& into,
                           const LoopTerms<Lanes>& from) {
  into.bz = lanes_select(where, from.bz, into.bz);
  into.br = lanes_select(where, from.br, into.br);
  into.br_over_rho = lanes_select(where, from.br_over_rho, into.br_over_rho);
  into.dz_bz = lanes_select(where, from.dz_bz, into.dz_bz);
  into.dz_br = lanes_select(where, from.dz_br, into.dz_br);
}

// Returns the field of a loop and the field's derivatives along z at points near the wire, from
// elliptic integrals. beyond = rho - 1.
template <class Lanes>
LOOMSTONE_INLINE LoopTerms<Lanes> loop_near(const Lanes& rho, const Lanes& beyond,
                                            const Lanes& zeta) {
  const Lanes sum = rho + 1.0;
  const Lanes alpha2 = zeta * zeta + sum * sum;
  const Lanes beta2 = lanes_max(zeta * zeta + beyond * beyond, lanes_all<Lanes>(1e-30));
  const Lanes kc2 = beta2 / alpha2, alpha = lanes_sqrt(alpha2), cube = 1.0 / (pi * alpha2 * alpha);
  Lanes a[2] = {lanes_all<Lanes>(1.0), Lanes{}}, b[2] = {Lanes{}, lanes_all<Lanes>(1.0)};
  elliptic<2>(lanes_sqrt(kc2), kc2, a, b);
  const Lanes c3 = a[0], s3 = a[1];  // integrals of c/Delta^3 and s/Delta^3
  const Lanes c5 = (2.0 * c3 + s3) / 3.0, s5 = (2.0 * s3 + c3) / (3.0 * kc2);
  LoopTerms<Lanes> out;
  out.bz = cube * (sum * c3 - beyond * s3);
  out.br = cube * zeta * (s3 - c3);
  out.br_over_rho = out.br / rho;
  out.dz_bz = -3.0 * zeta * cube / alpha2 * (sum * c5 - beyond * s5);
  out.dz_br = cube * (s3 - c3) - 3.0 * zeta * zeta * cube / alpha2 * (s5 - c5);
  return out;
}

// Returns the field of a loop and the field's derivatives along z at points near the axis or far
// from the loop, by the midpoint rule. Integrals with cos phi are integrated by parts to avoid
// cancellation.
template <class Lanes>
LOOMSTONE_INLINE LoopTerms<Lanes> loop_smooth(const Lanes& rho, const Lanes& beyond,
                                              const Lanes& zeta) {
  const Lanes sum2 = (rho + 1.0) * (rho + 1.0), beyond2 = beyond * beyond, zeta2 = zeta * zeta,
              rho2 = rho * rho;
  Lanes bz = Lanes{}, br = bz, dz_bz = bz, dz_br = bz;
  for (int i = 0; i < n_azimuths; ++i) {
    const double c = azimuths.c[i], s = azimuths.s[i], sine2 = 4.0 * s * c;
    const Lanes i2 = 1.0 / (zeta2 + sum2 * c + beyond2 * s), i3 = i2 * lanes_sqrt(i2), i5 = i3 * i2;
    // Integrands that replace cos phi / D^3 and cos phi / D^5 after integration by parts, both
    // divided by rho.
    const Lanes cosine = 3.0 * sine2 * i5;
    const Lanes cosine5 = 5.0 * sine2 * i5 * i2;
    bz += i3 - rho2 * cosine;
    br += cosine;
    dz_bz += i5 - rho2 * cosine5;
    dz_br += cosine - 3.0 * zeta2 * cosine5;
  }
  constexpr double weight = 0.5 / n_azimuths;
  LoopTerms<Lanes> out;
  out.bz = weight * bz;
  out.br_over_rho = weight * zeta * br;
  out.br = rho * out.br_over_rho;
  out.dz_bz = -3.0 * weight * zeta * dz_bz;
  out.dz_br = weight * rho * dz_br;
  return out;
}

template <class Lanes>
LOOMSTONE_INLINE LoopTerms<Lanes> loop_terms(const Lanes& rho, const Lanes& beyond,
                                             const Lanes& zeta) {
  const Lanes beta2 = zeta * zeta + beyond * beyond,
              alpha2 = zeta * zeta + (rho + 1.0) * (rho + 1.0);
  const MaskOf<Lanes> far = beta2 > smooth * alpha2;
  LoopTerms<Lanes> out = {};
  if (lanes_any(far)) out = loop_smooth(rho, beyond, zeta);
  if (lanes_any(~far)) take(~far, out, loop_near(rho, beyond, zeta));
  return out;
}

// Contribution of one end of a sheet to bz, br and t = A_phi / rho, from elliptic integrals. The
// derivatives of bz and br along z are the field of a loop at this end; see loop_terms().
template <class Lanes>
struct SheetEnd {
  Lanes bz, br, t;
};

template <class Lanes>
LOOMSTONE_INLINE SheetEnd<Lanes> sheet_end(const Lanes& rho, const Lanes& beyond,
                                           const Lanes& zeta) {
  const Lanes sum = rho + 1.0, ratio = -beyond / sum, p = ratio * ratio;
  const Lanes alpha2 = zeta * zeta + sum * sum,
              beta2 = lanes_max(zeta * zeta + beyond * beyond, lanes_all<Lanes>(1e-30));
  const Lanes kc = lanes_sqrt(beta2 / alpha2), inverse = 1.0 / lanes_sqrt(alpha2);
  Lanes a1[2] = {lanes_all<Lanes>(-1.0), p}, b1[2] = {lanes_all<Lanes>(1.0), lanes_all<Lanes>(1.0)};
  // Integrals of (s - c) / Delta and (p c + s) / Delta over theta; see the top of this file.
  elliptic<2>(kc, lanes_all<Lanes>(1.0), a1, b1);
  Lanes a2[2] = {lanes_all<Lanes>(1.0), lanes_all<Lanes>(1.0)},
        b2[2] = {ratio, lanes_all<Lanes>(1.0)};
  elliptic<2>(kc, p, a2, b2);
  SheetEnd<Lanes> out;
  out.bz = zeta * inverse / (pi * sum) * a2[0];
  out.br = -inverse / pi * a1[0];
  const Lanes q = 1.0 - p;
  out.t = 4.0 * zeta * inverse / (pi * sum * sum * q * q) * (a1[1] - p * a2[1]);
  return out;
}

template <class Lanes>
LOOMSTONE_INLINE SheetTerms<Lanes> sheet_near(const Lanes& rho, const Lanes& beyond,
                                              const Lanes& z1, const Lanes& z0, bool gradient) {
  const SheetEnd<Lanes> e1 = sheet_end(rho, beyond, z1), e0 = sheet_end(rho, beyond, z0);
  SheetTerms<Lanes> out = {};
  out.bz = e1.bz - e0.bz;
  out.br = e1.br - e0.br;
  out.t = e1.t - e0.t;
  out.br_over_rho = out.br / rho;
  if (gradient) {
    const LoopTerms<Lanes> l1 = loop_terms(rho, beyond, z1), l0 = loop_terms(rho, beyond, z0);
    out.dz_bz = l1.bz - l0.bz;
    out.dz_br = l1.br - l0.br;
    out.w = (2.0 * out.t - out.bz) / rho;
  }
  return out;
}

template <class Lanes>
LOOMSTONE_INLINE SheetTerms<Lanes> sheet_smooth(const Lanes& rho, const Lanes& beyond,
                                                const Lanes& z1, const Lanes& z0, double length,
                                                bool gradient) {
  const Lanes sum2 = (rho + 1.0) * (rho + 1.0), beyond2 = beyond * beyond, rho2 = rho * rho;
  const Lanes z12 = z1 * z1, z02 = z0 * z0, middle = z1 + z0;
  // True if the point is above both ends or below both. The difference between the contributions of
  // the ends is then computed without cancellation.
  const MaskOf<Lanes> aside = z1 * z0 > 0.0;
  const Lanes zero{};
  Lanes bz = zero, t = zero, br = zero, dz_bz = zero, dz_br = zero, w = zero;
  for (int i = 0; i < n_azimuths; ++i) {
    const double c = azimuths.c[i], s = azimuths.s[i], sine2 = 4.0 * s * c;
    const Lanes q = sum2 * c + beyond2 * s;
    const Lanes d1 = lanes_sqrt(z12 + q), d0 = lanes_sqrt(z02 + q), i1 = 1.0 / d1, i0 = 1.0 / d0;
    // `value` is Q, which is zeta / (q D) at the lower end minus the same at the upper end, with
    // q = D^2 - zeta^2. `slope` is R = -dQ / d(q/2).
    const Lanes mixed = z1 * d0 + z0 * d1, inverse = i1 * i0;
    const Lanes cross = lanes_select(aside, mixed, lanes_all<Lanes>(1.0));
    const Lanes aside_q = length * middle * inverse / cross;
    const Lanes aside_r = aside_q * (i1 * i1 + i0 * i0 + inverse * (z1 * d1 + z0 * d0) / cross);
    const Lanes over = 1.0 / lanes_max(q, lanes_all<Lanes>(1e-30)), a = z1 * i1 - z0 * i0;
    const Lanes across_r = (2.0 * a * over + z1 * i1 * i1 * i1 - z0 * i0 * i0 * i0) * over;
    const Lanes value = lanes_select(aside, aside_q, a * over),
                slope = lanes_select(aside, aside_r, across_r);
    bz += value - rho2 * sine2 * slope;
    t += sine2 * value;
    const Lanes i_difference = -length * middle * inverse / (d1 + d0);  // 1/D1 - 1/D0
    const Lanes i3_difference = i_difference * (i1 * i1 + inverse + i0 * i0);
    br -= sine2 * i3_difference;
    if (gradient) {
      const Lanes i12 = i1 * i1, i02 = i0 * i0;
      const Lanes i5_difference =
          i_difference * (i12 * i12 + i12 * inverse + i12 * i02 + inverse * i02 + i02 * i02);
      dz_bz += i3_difference - 3.0 * rho2 * sine2 * i5_difference;
      dz_br += 3.0 * sine2 *
               (0.5 * length * (i12 * i12 * i1 + i02 * i02 * i0) + 0.5 * middle * i5_difference);
      w += sine2 * slope * (rho + (c - s));
    }
  }
  constexpr double weight = 0.5 / n_azimuths;
  SheetTerms<Lanes> out;
  out.bz = weight * bz;
  out.t = weight * t;
  out.br_over_rho = weight * br;
  out.br = rho * out.br_over_rho;
  out.dz_bz = weight * dz_bz;
  out.dz_br = weight * rho * dz_br;
  out.w = weight * w;
  return out;
}

// Returns the terms of a sheet. z1 and z0 are the heights of the point above the lower and the
// upper end, so z1 - z0 = length. beyond = rho - 1. Unless `gradient` is true, dz_bz, dz_br and w
// are 0.
template <class Lanes>
LOOMSTONE_INLINE SheetTerms<Lanes> sheet_terms(const Lanes& rho, const Lanes& beyond,
                                               const Lanes& z1, const Lanes& z0, double length,
                                               bool gradient) {
  const Lanes sum = rho + 1.0, sum2 = sum * sum, beyond2 = beyond * beyond;
  const MaskOf<Lanes> far = (beyond2 > smooth * sum2) |
                            ((z1 * z0 > 0.0) & (z1 * z1 + beyond2 > smooth * (z1 * z1 + sum2)) &
                             (z0 * z0 + beyond2 > smooth * (z0 * z0 + sum2)));
  SheetTerms<Lanes> out = {};
  if (lanes_any(far)) out = sheet_smooth(rho, beyond, z1, z0, length, gradient);
  if (lanes_any(~far)) {
    const SheetTerms<Lanes> close = sheet_near(rho, beyond, z1, z0, gradient);
    out.bz = lanes_select(far, out.bz, close.bz);
    out.br = lanes_select(far, out.br, close.br);
    out.br_over_rho = lanes_select(far, out.br_over_rho, close.br_over_rho);
    out.t = lanes_select(far, out.t, close.t);
    out.dz_bz = lanes_select(far, out.dz_bz, close.dz_bz);
    out.dz_br = lanes_select(far, out.dz_br, close.dz_br);
    out.w = lanes_select(far, out.w, close.w);
  }
  return out;
}

}  // namespace loomstone
