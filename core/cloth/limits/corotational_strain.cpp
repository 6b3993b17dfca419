#include "core/cloth/limits/corotational_strain.h"

#include <algorithm>
#include <cmath>

#include "core/cloth/limits/element_limit.h"

namespace loomstone {

Vec3 corotational_strain(const Vec3& green) {
  const double c11 = 1.0 + 2.0 * green[0], c22 = 1.0 + 2.0 * green[1], c12 = 2.0 * green[2];
  const double d = std::sqrt(std::max(0.0, c11 * c22 - c12 * c12)),
               s = std::sqrt(c11 + c22 + 2.0 * d) + 1e-300;
  return {(c11 + d) / s - 1.0, (c22 + d) / s - 1.0, c12 / s};
}

Vec3 corotational_strain(const Triangles& triangles, const Corners2& corners, const Points& x,
                         Index triangle) {
  const Vec2 e0 = (corners.row(0) - corners.row(2)).transpose(),
             e1 = (corners.row(1) - corners.row(2)).transpose();
  const double determinant = e0.x() * e1.y() - e0.y() * e1.x();
  limit::Element<double> element{};
  element.g0x = e1.y() / determinant, element.g0y = -e1.x() / determinant;
  element.g1x = -e0.y() / determinant, element.g1y = e0.x() / determinant;
  const auto corner = [&](int k) {
    const Index v = triangles(triangle, k);
    return limit::Space<double>{x(v, 0), x(v, 1), x(v, 2)};
  };
  const limit::Polar<double> p = limit::stretch(element, corner(0), corner(1), corner(2));
  return {p.u.a11 - 1.0, p.u.a22 - 1.0, p.u.a12};
}

void corotational_strain(const Team& team, const Triangles& triangles,
                         const std::vector<Corners2>& corners, const Points& x, Points& strain) {
  strain.resize(triangles.rows(), 3);
  parallel_for(team, static_cast<Index>(triangles.rows()), [&](Index t) {
    strain.row(t) = corotational_strain(triangles, corners[t], x, t).transpose();
  });
}

}  // namespace loomstone
