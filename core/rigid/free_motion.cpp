#include "core/rigid/free_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/rigid/shape_geometry.h"

namespace loomstone {

namespace {

// Returns the rotation by `angle` [rad] about axis k of the rotor, as a quaternion in body axes.
Vec4 about_axis(const Rotor& rotor, int k, double angle) {
  return quaternion_from_rotation_vector(rotor.axes.col(k) * angle);
}

}  // namespace

Rotor make_rotor(const Mat3& inertia) {
  Rotor rotor;
  rotor.axes = principal_axes(inertia);
  rotor.moments = (rotor.axes.transpose() * inertia * rotor.axes).diagonal();
  return rotor;
}

Vec3 angular_momentum(const Rotor& rotor, const Vec4& orientation, const Vec3& angular_velocity) {
  const Mat3 axes = rotation_matrix(orientation) * rotor.axes;
  return axes * rotor.moments.cwiseProduct(axes.transpose() * angular_velocity);
}

Vec3 angular_velocity(const Rotor& rotor, const Vec4& orientation, const Vec3& angular_momentum) {
  const Mat3 axes = rotation_matrix(orientation) * rotor.axes;
  return axes * (axes.transpose() * angular_momentum).cwiseQuotient(rotor.moments);
}

Vec4 freely_turned(const Rotor& rotor, const Vec4& orientation, const Vec3& angular_momentum,
                   double step) {
  // B is the moment of inertia whose inverse is closest to the inverse of one of the other two.
  // Axially symmetric bodies then need rotations about two axes only.
  const Vec3 inverse = rotor.moments.cwiseInverse();
  int b = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double gap = std::min(std::abs(inverse[(k + 1) % 3] - inverse[k]),
                                std::abs(inverse[(k + 2) % 3] - inverse[k]));
    if (gap < nearest) nearest = gap, b = k;
  }
  const int a = (b + 1) % 3, c = (b + 2) % 3;
  const double rate_a = inverse[a] - inverse[b], rate_c = inverse[c] - inverse[b];
  const Vec4 about_momentum =
      quaternion_from_rotation_vector(angular_momentum * (step * inverse[b]));
  Vec4 q = orientation;
  const auto momentum_along = [&](int k) {
    return (rotation_matrix(q) * rotor.axes.col(k)).dot(angular_momentum);
  };
  q = quaternion_product(q, about_axis(rotor, a, 0.5 * step * rate_a * momentum_along(a)));
  q = quaternion_product(q, about_axis(rotor, c, 0.5 * step * rate_c * momentum_along(c)));
  q = quaternion_product(about_momentum, q);
  q = quaternion_product(q, about_axis(rotor, c, 0.5 * step * rate_c * momentum_along(c)));
  q = quaternion_product(q, about_axis(rotor, a, 0.5 * step * rate_a * momentum_along(a)));
  return q.normalized();
}

}  // namespace loomstone
