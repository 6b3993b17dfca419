#include "core/magnetics/sources/axisymmetric.h"

#include <algorithm>
#include <cmath>

#include "core/base/message.h"
#include "core/magnetics/sources/axisymmetric_kernels.h"
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

void add_cylinder_field(const Sheet& sheet, const Vec3& j, const Vec3& jump, const double* points,
                        Index n, double* out) {
  alignas(64) double part[3 * points_per_block];
  const auto kernel = [&](const double* some, Index m, double* values) {
    LOOMSTONE_WIDEST(cylinder_field)(sheet, j.data(), jump.data(), some, m, values);
  };
  split_block({points, n, part, 3}, Smooth{sheet.radius, 0.5 * sheet.height}, kernel, kernel);
  for (Index i = 0; i < 3 * n; ++i) out[i] += part[i];
}

void add_cylinder_gradient(const Sheet& sheet, const Vec3& j, const double* points, Index n,
                           double* out) {
  alignas(64) double part[6 * points_per_block];
  const auto kernel = [&](const double* some, Index m, double* values) {
    LOOMSTONE_WIDEST(cylinder_gradient)(sheet, j.data(), some, m, values);
  };
  split_block({points, n, part, 6}, Smooth{sheet.radius, 0.5 * sheet.height}, kernel, kernel);
  for (Index i = 0; i < 6 * n; ++i) out[i] += part[i];
}

void need_positive(double value, const char* name, const char* unit) {
  if (!(value > 0.0) || !std::isfinite(value))
    fail<InvalidInput>("{} must be > 0 [{}], got {}", name, unit, value);
}

void need_finite(double value, const char* name, const char* unit) {
  if (!std::isfinite(value))
    fail<InvalidInput>("{} must be finite [{}], got {}", name, unit, value);
}

}  // namespace

Loop::Loop(double radius, double current, double turns)
    : radius_(radius), current_(current), turns_(turns), ampere_turns_(turns * current) {
  need_positive(radius, "radius", "m");
  need_positive(turns, "turns", "1");
  need_finite(current, "current", "A");
}

void Loop::field_block(const double* points, Index n, Quantity, double* field) const {
  const auto kernel = [&](const double* some, Index m, double* out) {
    LOOMSTONE_WIDEST(loop_field)(radius_, mu0 * ampere_turns_ / radius_, some, m, out);
  };
  split_block({points, n, field, 3}, Smooth{radius_, 0.0}, kernel, kernel);
}

void Loop::gradient_block(const double* points, Index n, double* gradient) const {
  const double strength = mu0 * ampere_turns_ / (radius_ * radius_);
  const auto kernel = [&](const double* some, Index m, double* out) {
    LOOMSTONE_WIDEST(loop_gradient)(radius_, strength, some, m, out);
  };
  split_block({points, n, gradient, 6}, Smooth{radius_, 0.0}, kernel, kernel);
}

void Loop::vector_potential_block(const double* points, Index n, double* potential) const {
  LOOMSTONE_WIDEST(vector_potential)(Sheet{radius_, 0.0, 1.0}, mu0 * ampere_turns_, points, n,
                                     potential);
}

Vec3 Loop::moment() const { return {0.0, 0.0, ampere_turns_ * pi * radius_ * radius_}; }

SourceRecipe Loop::recipe() const {
  return {"loop", {{"radius", radius_}, {"turns", turns_}, {"current", current_}}, {}, {}};
}

Solenoid::Solenoid(double radius, double length, double turns, double current)
    : radius_(radius), length_(length), turns_(turns), current_(current) {
  need_positive(radius, "radius", "m");
  need_positive(length, "length", "m");
  need_positive(turns, "turns", "1");
  need_finite(current, "current", "A");
  sheet_ = turns * current / length;
}

void Solenoid::field_block(const double* points, Index n, Quantity, double* field) const {
  std::fill_n(field, 3 * n, 0.0);
  add_cylinder_field({radius_, length_, 1.0}, {0.0, 0.0, mu0 * sheet_}, Vec3::Zero(), points, n,
                     field);
}

void Solenoid::gradient_block(const double* points, Index n, double* gradient) const {
  std::fill_n(gradient, 6 * n, 0.0);
  add_cylinder_gradient({radius_, length_, 1.0}, {0.0, 0.0, mu0 * sheet_}, points, n, gradient);
}

void Solenoid::vector_potential_block(const double* points, Index n, double* potential) const {
  LOOMSTONE_WIDEST(vector_potential)(Sheet{radius_, length_, 1.0}, mu0 * sheet_ * radius_, points,
                                     n, potential);
}

double Solenoid::radius() const { return std::hypot(radius_, 0.5 * length_); }

Vec3 Solenoid::moment() const { return {0.0, 0.0, sheet_ * length_ * pi * radius_ * radius_}; }

SourceRecipe Solenoid::recipe() const {
  return {"solenoid",
          {{"radius", radius_}, {"length", length_}, {"turns", turns_}, {"current", current_}},
          {},
          {}};
}

Cylinder::Cylinder(double radius, double height, const Vec3& polarization, double inner_radius)
    : radius_(radius), inner_(inner_radius), height_(height), polarization_(polarization) {
  need_positive(radius, "radius", "m");
  need_positive(height, "height", "m");
  if (!(inner_radius >= 0.0 && inner_radius < radius))
    fail<InvalidInput>("inner_radius must be >= 0 and below radius {} [m], got {}", radius,
                       inner_radius);
  for (int k = 0; k < 3; ++k) need_finite(polarization[k], "polarization", "T");
}

SourceRecipe Cylinder::recipe() const {
  return {"cylinder",
          {{"radius", radius_},
           {"height", height_},
           {"inner_radius", inner_},
           {"polarization", polarization_}},
          {},
          {}};
}

void Cylinder::field_block(const double* points, Index n, Quantity quantity, double* field) const {
  const Vec3 jump = quantity == Quantity::flux_density ? Vec3(Vec3::Zero()) : polarization_;
  std::fill_n(field, 3 * n, 0.0);
  add_cylinder_field({radius_, height_, 1.0}, polarization_, jump, points, n, field);
  if (inner_ > 0.0)
    add_cylinder_field({inner_, height_, -1.0}, -polarization_, -jump, points, n, field);
}

void Cylinder::gradient_block(const double* points, Index n, double* gradient) const {
  std::fill_n(gradient, 6 * n, 0.0);
  add_cylinder_gradient({radius_, height_, 1.0}, polarization_, points, n, gradient);
  if (inner_ > 0.0)
    add_cylinder_gradient({inner_, height_, -1.0}, -polarization_, points, n, gradient);
}

void Cylinder::potential_block(const double* points, Index n, double* potential) const {
  LOOMSTONE_WIDEST(cylinder_potential)(Sheet{radius_, height_, 1.0}, polarization_.data(), points,
                                       n, potential);
  if (inner_ == 0.0) return;
  alignas(64) double bore[points_per_block];
  LOOMSTONE_WIDEST(cylinder_potential)(Sheet{inner_, height_, -1.0}, polarization_.data(), points,
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

// Appends the four quarters of a circle, side or disc.
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
  p.current = ampere_turns_;
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
