#include "core/magnetics/forces/sphere_series.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/magnetics/sources/spherical_harmonics.h"

namespace loomstone {

namespace {

constexpr double slowest_decay = 1e-3;

}  // namespace

double distance_to_source(const MagneticBody& body, const Vec3& point) {
  const Vec3 local = in_axes(body.pose, point);
  double nearest = std::numeric_limits<double>::infinity();
  if (const DipoleSet* set = body.source->dipoles()) {
    for (Eigen::Index i = 0; i < set->positions().rows(); ++i)
      nearest = std::min(nearest, (set->positions().row(i).transpose() - local).norm());
    return nearest;
  }
  if (body.source->box()) return -body.source->depth(local);
  constexpr int parts = 16;
  for (const Panel& panel : body.source->panels()) {
    for (int i = 0; i <= parts; ++i)
      for (int k = 0; k <= (panel.line() ? 0 : parts); ++k)
        nearest = std::min(
            nearest, (panel.at(double(i) / parts, double(k) / parts).position - local).norm());
  }
  return nearest;
}

double sphere_decay(double radius, double distance) {
  return std::max(2.0 * std::log(std::max(distance / radius, 1.0)), slowest_decay);
}

double sphere_decay(double radius, double other, double distance) {
  // Repeated images accumulate at the distance radius exp(-eta) from the centre of this sphere,
  // where eta = acosh(cosine) is the bispherical coordinate of its surface. Terms of degree l
  // therefore decay as exp(-2 eta l).
  const double cosine =
      (distance * distance + radius * radius - other * other) / (2.0 * radius * distance);
  return std::max(2.0 * std::acosh(std::max(cosine, 1.0)), slowest_decay);
}

// Let x be `decay`. Terms of degree l of the force between a dipole and a sphere are assumed to
// decay as l^4 exp(-x l), which is slower than in truncated_share(). The relative error of
// truncation at degree d is then about y^4 exp(-y) / 24 with y = x d. The loop solves for y.
int degree_of(double decay, double tolerance) {
  double y = -std::log(tolerance);
  for (int i = 0; i < 20; ++i)
    y = -std::log(tolerance) + 4.0 * std::log(std::max(y, 3.0)) - std::log(24.0);
  return static_cast<int>(std::min<double>(std::ceil(y / decay) + 2.0, SphericalHarmonics::most));
}

// For a dipole that points to the sphere's centre, terms of degree l of the force are approximately
// proportional to (l + 3/2)^3 exp(-x l), where x is SeriesEnd::decay. The terms that the series
// omits also contribute to the field at its sample points, and thus change the terms that it
// contains. The factor `sampled` for this effect is fitted to true relative errors between 1e-8 and
// 0.3, for dipoles at distances of 1.005 to 2 radii from the centre. For degrees from 10 on, the
// estimate is 0.5 to 4 times the true error.
double truncated_share(const SeriesEnd& end) {
  const double sampled = std::clamp(0.8 * (end.degree - 2), 0.0, 40.0);
  // Sum of the terms beyond a degree, divided by a factor that does not depend on the degree.
  const auto beyond = [&](double degree) {
    const double y = end.decay * (degree + 2.0);
    return std::exp(-y) * (1.0 + y + y * y / 2.0 + y * y * y / 6.0);
  };
  return sampled * beyond(end.degree) / beyond(0.0);
}

}  // namespace loomstone
