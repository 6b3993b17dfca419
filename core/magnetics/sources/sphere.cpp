#include "core/magnetics/sources/sphere.h"

#include <cmath>

#include "core/base/message.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

Points sphere_moment(double radius, const Vec3& polarization) {
  return (polarization * (4.0 / 3.0 * pi * radius * radius * radius / mu0)).transpose();
}

bool inside(const double* points, Index n, Index i, double radius) {
  return std::hypot(points[i], points[n + i], points[2 * n + i]) < radius * (1.0 - 1e-12);
}

}  // namespace

Sphere::Sphere(double radius, const Vec3& polarization)
    : radius_(radius),
      polarization_(polarization),
      dipole_(Points::Zero(1, 3), sphere_moment(radius, polarization)) {
  if (!(radius > 0.0) || !std::isfinite(radius))
    fail<InvalidInput>("radius must be > 0 [m], got {}", radius);
}

void Sphere::field_block(const double* points, Index n, Quantity quantity, double* field) const {
  dipole_.field_block(points, n, quantity, field);
  const double share = quantity == Quantity::flux_density ? 2.0 / 3.0 : -1.0 / 3.0;
  for (Index i = 0; i < n; ++i)
    if (inside(points, n, i, radius_))
      for (int c = 0; c < 3; ++c) field[c * n + i] = share * polarization_[c];
}

void Sphere::gradient_block(const double* points, Index n, double* gradient) const {
  dipole_.gradient_block(points, n, gradient);
  for (Index i = 0; i < n; ++i)
    if (inside(points, n, i, radius_))
      for (int c = 0; c < 6; ++c) gradient[c * n + i] = 0.0;
}

void Sphere::potential_block(const double* points, Index n, double* potential) const {
  dipole_.potential_block(points, n, potential);
  for (Index i = 0; i < n; ++i)
    if (inside(points, n, i, radius_))
      potential[i] = polarization_.dot(Vec3(points[i], points[n + i], points[2 * n + i])) / 3.0;
}

}  // namespace loomstone
