#include "core/magnetics/sources/axisymmetric.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/magnetics/sources/axisymmetric_terms.h"
#include "core/magnetics/sources/split_block.h"

namespace loomstone {

const Azimuths azimuths = [] {
  Azimuths a;
  for (int i = 0; i < n_azimuths; ++i) {
    const double theta = 0.5 * pi * (i + 0.5) / n_azimuths;
    a.c[i] = std::cos(theta) * std::cos(theta);
    a.s[i] = std::sin(theta) * std::sin(theta);
  }
  return a;
}();

namespace {

constexpr double on_surface = 1e-12;

// Unit vector away from the axis (x on the axis itself); in radii the distance to the axis, that
// less 1, and the height.
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

// Symmetric tensor in the axes (rho, phi, z) to Cartesian ones, stored as xx, xy, xz, yy, yz, zz.
template <class Lanes>
LOOMSTONE_INLINE void store_tensor(const Cylindrical<Lanes>& p, const Lanes& rr, const Lanes& rp,
                                   const Lanes& pp, const Lanes& rz, const Lanes& pz,
                                   const Lanes& zz, Index n, double* out) {
  const Lanes c = p.cosine, s = p.sine;
  lanes_store(out, c * c * rr - 2.0 * c * s * rp + s * s * pp);
  lanes_store(out + n, c * s * (rr - pp) + (c * c - s * s) * rp);
  lanes_store(out + 2 * n, c * rz - s * pz);
  lanes_store(out + 3 * n, s * s * rr + 2.0 * c * s * rp + c * c * pp);
  lanes_store(out + 4 * n, s * rz + c * pz);
  lanes_store(out + 5 * n, zz);
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
    const Lanes zero{};
    store_tensor(p, strength * (-t.dz_bz - t.br_over_rho), zero, strength * t.br_over_rho,
                 strength * t.dz_br, zero, strength * t.dz_bz, n, out + i);
  }
}

template <class Lanes>
struct SheetPoint {
  Cylindrical<Lanes> p;
  Lanes beyond, z1, z0;  // rho - 1; heights above the lower and the upper end
  MaskOf<Lanes> inside;
};

// side: +1 or -1, on which side of the sheet a point on it counts.
template <class Lanes>
LOOMSTONE_INLINE SheetPoint<Lanes> sheet_point(const double* points, Index n, Index i,
                                               double radius, double length, double side) {
  SheetPoint<Lanes> s;
  s.p = cylindrical<Lanes>(points, n, i, radius);
  s.beyond = lanes_select(lanes_abs(s.p.beyond) < on_surface, lanes_all<Lanes>(side * on_surface),
                          s.p.beyond);
  const double half = 0.5 * length * radius, scale = 1.0 / radius;
  const Lanes z = lanes_load<Lanes>(points + 2 * n + i);
  s.z1 = (z + half) * scale;
  s.z0 = (z - half) * scale;
  s.inside = (s.beyond < 0.0) & (s.z1 > on_surface) & (s.z0 < -on_surface);
  return s;
}

// Field of a cylinder, length in radii. jump: what has to be subtracted from B inside.
template <class Lanes>
LOOMSTONE_INLINE void cylinder_field(double radius, double length, double side, const double* j,
                                     const double* jump, const double* points, Index n,
                                     double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const SheetPoint<Lanes> s = sheet_point<Lanes>(points, n, i, radius, length, side);
    const Cylindrical<Lanes>& p = s.p;
    const SheetTerms<Lanes> t = sheet_terms(p.rho, s.beyond, s.z1, s.z0, length, false);
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
LOOMSTONE_INLINE void cylinder_gradient(double radius, double length, double side, const double* j,
                                        const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const SheetPoint<Lanes> s = sheet_point<Lanes>(points, n, i, radius, length, side);
    const Cylindrical<Lanes>& p = s.p;
    const SheetTerms<Lanes> t = sheet_terms(p.rho, s.beyond, s.z1, s.z0, length, true);
    const double scale = 1.0 / radius;
    const Lanes jr = scale * (j[0] * p.cosine + j[1] * p.sine),
                jp = scale * (j[1] * p.cosine - j[0] * p.sine);
    const double jz = scale * j[2];
    // Third derivatives of Psi: phi phi rho = w, phi phi z = b_rho / rho, rho zz and zzz from the
    // loops, the rest by Laplace.
    const Lanes rrz = -t.dz_bz - t.br_over_rho, rrr = -t.w - t.dz_br;
    store_tensor(p, rrr * jr + rrz * jz, t.w * jp, t.w * jr + t.br_over_rho * jz,
                 rrz * jr + t.dz_br * jz, t.br_over_rho * jp, t.dz_br * jr + t.dz_bz * jz, n,
                 out + i);
  }
}

// Potential of a ring of unit charge.
template <class Lanes>
LOOMSTONE_INLINE Lanes ring_potential(const Lanes& rho, const Lanes& beyond, const Lanes& zeta) {
  const Lanes alpha2 = zeta * zeta + (rho + 1.0) * (rho + 1.0);
  const Lanes beta2 = lanes_max(zeta * zeta + beyond * beyond, lanes_all<Lanes>(1e-30));
  Lanes a[1] = {lanes_all<Lanes>(1.0)}, b[1] = {lanes_all<Lanes>(1.0)};
  elliptic<1>(lanes_sqrt(beta2 / alpha2), lanes_all<Lanes>(1.0), a, b);
  return a[0] / (pi * lanes_sqrt(alpha2));
}

template <class Lanes>
LOOMSTONE_INLINE void cylinder_potential(double radius, double length, double side, const double* j,
                                         const double* points, Index n, double* out) {
  constexpr double axis =
      1e-4;  // below it the first term of the series in rho is good to its square
  const Lanes zero{};
  for (Index i = 0; i < n; i += n_lanes) {
    const SheetPoint<Lanes> s = sheet_point<Lanes>(points, n, i, radius, length, side);
    const Cylindrical<Lanes>& p = s.p;
    const SheetTerms<Lanes> t = sheet_terms(p.rho, s.beyond, s.z1, s.z0, length, false);
    const Lanes jr = radius * (j[0] * p.cosine + j[1] * p.sine);
    const double jz = radius * j[2];
    const Lanes z_field = t.bz - lanes_select(s.inside, lanes_all<Lanes>(1.0), zero);
    const Lanes along = p.rho * ((t.t - t.bz) * jr + t.br * jz) + p.z * (t.br * jr + z_field * jz);
    // Both ends with unit charge: what a sheet that ends there has, but for its inside.
    const SheetEnd<Lanes> e1 = sheet_end(p.rho, s.beyond, s.z1),
                          e0 = sheet_end(p.rho, s.beyond, s.z0);
    const Lanes below =
                    lanes_select(s.z1 > on_surface, lanes_all<Lanes>(0.5), lanes_all<Lanes>(-0.5)),
                above =
                    lanes_select(s.z0 < -on_surface, lanes_all<Lanes>(-0.5), lanes_all<Lanes>(0.5));
    const Lanes ends_z = lanes_select(s.beyond < 0.0, below + above, zero) - e1.bz - e0.bz,
                ends_r = -e1.br - e0.br;
    // The side with unit charge: rho times its radial field and the field of the sheet, both over
    // its charge, add up.
    const Lanes ring1 = ring_potential(p.rho, s.beyond, s.z1),
                ring0 = ring_potential(p.rho, s.beyond, s.z0);
    const Lanes c1 = 1.0 / lanes_sqrt(1.0 + s.z1 * s.z1), c0 = 1.0 / lanes_sqrt(1.0 + s.z0 * s.z0);
    const MaskOf<Lanes> on_axis = p.rho < axis;
    const Lanes side_r = lanes_select(
        on_axis, 0.25 * p.rho * (s.z0 * c0 * c0 * c0 - s.z1 * c1 * c1 * c1),
        (s.z1 * ring1 - s.z0 * ring0 - t.bz) / lanes_select(on_axis, lanes_all<Lanes>(1.0), p.rho));
    const Lanes layer =
        jr * (side_r + 0.5 * length * ends_r) + jz * (ring0 - ring1 + 0.5 * length * ends_z);
    lanes_store(out + i, layer - along);
  }
}

// length 0: of a loop, else of a sheet; along the azimuth.
template <class Lanes>
LOOMSTONE_INLINE void vector_potential(double radius, double length, double strength,
                                       const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const SheetPoint<Lanes> s = sheet_point<Lanes>(points, n, i, radius, length, 1.0);
    Lanes along;
    if (length > 0.0)
      along = strength * s.p.rho * sheet_terms(s.p.rho, s.beyond, s.z1, s.z0, length, false).t;
    else
      along = -strength * sheet_end(s.p.rho, s.beyond, s.p.z).br;
    lanes_store(out + i, -s.p.sine * along);
    lanes_store(out + n + i, s.p.cosine * along);
    lanes_store(out + 2 * n + i, Lanes{});
  }
}

// Points where a sheet's or loop's (length 0) integrals are smooth: the same rule as in
// sheet_terms, to group points alike.
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

// Adds the field of a cylinder.
void add_cylinder_field(double radius, double height, double side, const Vec3& j, const Vec3& jump,
                        const double* points, Index n, double* out) {
  alignas(64) double part[3 * points_per_block];
  const auto kernel = [&](const double* some, Index m, double* values) {
    LOOMSTONE_WIDEST(cylinder_field)(radius, height / radius, side, j.data(), jump.data(), some, m,
                                     values);
  };
  split_block(points, n, 3, part, Smooth{radius, 0.5 * height}, kernel, kernel);
  for (Index i = 0; i < 3 * n; ++i) out[i] += part[i];
}

void add_cylinder_gradient(double radius, double height, double side, const Vec3& j,
                           const double* points, Index n, double* out) {
  alignas(64) double part[6 * points_per_block];
  const auto kernel = [&](const double* some, Index m, double* values) {
    LOOMSTONE_WIDEST(cylinder_gradient)(radius, height / radius, side, j.data(), some, m, values);
  };
  split_block(points, n, 6, part, Smooth{radius, 0.5 * height}, kernel, kernel);
  for (Index i = 0; i < 6 * n; ++i) out[i] += part[i];
}

void need_positive(double value, const char* name, const char* unit) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw InvalidInput(std::string(name) + " must be > 0 [" + unit + "], got " +
                       std::to_string(value));
}

void need_finite(double value, const char* name, const char* unit) {
  if (!std::isfinite(value))
    throw InvalidInput(std::string(name) + " must be finite [" + unit + "], got " +
                       std::to_string(value));
}

}  // namespace

Loop::Loop(double radius, double current) : radius_(radius), current_(current) {
  need_positive(radius, "radius", "m");
  need_finite(current, "current", "A");
}

void Loop::field_block(const double* points, Index n, Quantity, double* field) const {
  const auto kernel = [&](const double* some, Index m, double* out) {
    LOOMSTONE_WIDEST(loop_field)(radius_, mu0 * current_ / radius_, some, m, out);
  };
  split_block(points, n, 3, field, Smooth{radius_, 0.0}, kernel, kernel);
}

void Loop::gradient_block(const double* points, Index n, double* gradient) const {
  const double strength = mu0 * current_ / (radius_ * radius_);
  const auto kernel = [&](const double* some, Index m, double* out) {
    LOOMSTONE_WIDEST(loop_gradient)(radius_, strength, some, m, out);
  };
  split_block(points, n, 6, gradient, Smooth{radius_, 0.0}, kernel, kernel);
}

void Loop::vector_potential_block(const double* points, Index n, double* potential) const {
  LOOMSTONE_WIDEST(vector_potential)(radius_, 0.0, mu0 * current_, points, n, potential);
}

Vec3 Loop::moment() const { return {0.0, 0.0, current_ * pi * radius_ * radius_}; }

Solenoid::Solenoid(double radius, double length, double turns, double current)
    : radius_(radius), length_(length) {
  need_positive(radius, "radius", "m");
  need_positive(length, "length", "m");
  need_positive(turns, "turns", "1");
  need_finite(current, "current", "A");
  sheet_ = turns * current / length;
}

void Solenoid::field_block(const double* points, Index n, Quantity, double* field) const {
  std::fill_n(field, 3 * n, 0.0);
  add_cylinder_field(radius_, length_, 1.0, {0.0, 0.0, mu0 * sheet_}, Vec3::Zero(), points, n,
                     field);
}

void Solenoid::gradient_block(const double* points, Index n, double* gradient) const {
  std::fill_n(gradient, 6 * n, 0.0);
  add_cylinder_gradient(radius_, length_, 1.0, {0.0, 0.0, mu0 * sheet_}, points, n, gradient);
}

void Solenoid::vector_potential_block(const double* points, Index n, double* potential) const {
  LOOMSTONE_WIDEST(vector_potential)(radius_, length_ / radius_, mu0 * sheet_ * radius_, points, n,
                                     potential);
}

double Solenoid::radius() const { return std::hypot(radius_, 0.5 * length_); }

Vec3 Solenoid::moment() const { return {0.0, 0.0, sheet_ * length_ * pi * radius_ * radius_}; }

Cylinder::Cylinder(double radius, double height, const Vec3& polarization, double inner_radius)
    : radius_(radius), inner_(inner_radius), height_(height), polarization_(polarization) {
  need_positive(radius, "radius", "m");
  need_positive(height, "height", "m");
  if (!(inner_radius >= 0.0 && inner_radius < radius))
    throw InvalidInput("inner_radius must be >= 0 and below radius " + std::to_string(radius) +
                       " [m], got " + std::to_string(inner_radius));
  for (int k = 0; k < 3; ++k) need_finite(polarization[k], "polarization", "T");
}

void Cylinder::field_block(const double* points, Index n, Quantity quantity, double* field) const {
  const Vec3 jump = quantity == Quantity::flux_density ? Vec3(Vec3::Zero()) : polarization_;
  std::fill_n(field, 3 * n, 0.0);
  add_cylinder_field(radius_, height_, 1.0, polarization_, jump, points, n, field);
  if (inner_ > 0.0)
    add_cylinder_field(inner_, height_, -1.0, -polarization_, -jump, points, n, field);
}

void Cylinder::gradient_block(const double* points, Index n, double* gradient) const {
  std::fill_n(gradient, 6 * n, 0.0);
  add_cylinder_gradient(radius_, height_, 1.0, polarization_, points, n, gradient);
  if (inner_ > 0.0)
    add_cylinder_gradient(inner_, height_, -1.0, -polarization_, points, n, gradient);
}

void Cylinder::potential_block(const double* points, Index n, double* potential) const {
  LOOMSTONE_WIDEST(cylinder_potential)(radius_, height_ / radius_, 1.0, polarization_.data(),
                                       points, n, potential);
  if (inner_ == 0.0) return;
  alignas(64) double bore[points_per_block];
  LOOMSTONE_WIDEST(cylinder_potential)(inner_, height_ / inner_, -1.0, polarization_.data(), points,
                                       n, bore);
  for (Index i = 0; i < n; ++i) potential[i] -= bore[i];
}

double Cylinder::radius() const { return std::hypot(radius_, 0.5 * height_); }

std::optional<std::pair<Vec3, Vec3>> Cylinder::box() const {
  const Vec3 half(radius_, radius_, 0.5 * height_);
  return std::pair(Vec3(-half), half);
}

double Cylinder::depth(const Vec3& point) const {
  const double rho = point.head<2>().norm(), end = 0.5 * height_ - std::abs(point.z());
  const double side = inner_ > 0.0 ? std::min(radius_ - rho, rho - inner_) : radius_ - rho;
  return side < 0.0 && end < 0.0 ? -std::hypot(side, end) : std::min(side, end);
}

Vec3 Cylinder::moment() const {
  return polarization_ * (pi * (radius_ * radius_ - inner_ * inner_) * height_ / mu0);
}

namespace {

// Four quarters of a circle, a side or a disc.
void add_quarters(Panel p, std::vector<Panel>& panels) {
  p.turn = 0.5 * pi;
  for (int k = 0; k < 4; ++k) {
    p.azimuth = 0.5 * pi * k;
    panels.push_back(p);
  }
}

}  // namespace

std::vector<Panel> Loop::panels() const {
  std::vector<Panel> panels;
  Panel p{Panel::Shape::circle};
  p.radius1 = radius_;
  p.current = current_;
  add_quarters(p, panels);
  return panels;
}

std::vector<Panel> Solenoid::panels() const {
  std::vector<Panel> panels;
  Panel p{Panel::Shape::side};
  p.radius1 = radius_;
  p.height0 = -0.5 * length_;
  p.height1 = 0.5 * length_;
  p.current = sheet_;
  add_quarters(p, panels);
  return panels;
}

std::vector<Panel> Cylinder::faces(bool all) const {
  std::vector<Panel> panels;
  const Vec3 magnetization = polarization_ / mu0;
  if (all || magnetization.head<2>().norm() > 0.0) {
    for (const double r : {radius_, inner_}) {
      if (r == 0.0) continue;
      Panel p{Panel::Shape::side};
      p.radius1 = r;
      p.height0 = -0.5 * height_;
      p.height1 = 0.5 * height_;
      p.magnetization = magnetization;
      p.sign = r == radius_ ? 1.0 : -1.0;
      add_quarters(p, panels);
    }
  }
  if (all || magnetization.z() != 0.0) {
    for (const double sign : {-1.0, 1.0}) {
      Panel p{Panel::Shape::disc};
      p.radius0 = inner_;
      p.radius1 = radius_;
      p.height0 = 0.5 * sign * height_;
      p.magnetization = magnetization;
      p.sign = sign;
      add_quarters(p, panels);
    }
  }
  return panels;
}

}  // namespace loomstone
