#include "core/magnetics/sources/panel.h"

#include <cmath>

namespace loomstone {

double Panel::reach(int boundary, double cosine, double sine) const {
  const Vec3& line = boundary == 0 ? line0 : line1;
  const double circle = boundary == 0 ? circle0 : circle1;
  if (line.x() != 0.0 || line.y() != 0.0)
    return line.squaredNorm() / (line.x() * cosine + line.y() * sine);
  if (!(circle > 0.0)) return boundary == 0 ? radius0 : radius1;
  const double along = a.x() * cosine + a.y() * sine, across = a.x() * sine - a.y() * cosine;
  return along + std::sqrt(circle * circle - across * across);
}

PanelSample Panel::at(double u, double v) const {
  PanelSample s;
  const bool round = shape == Shape::side || shape == Shape::disc || shape == Shape::circle;
  const double phi = azimuth + turn * u, cosine = round ? std::cos(phi) : 1.0,
               sine = round ? std::sin(phi) : 0.0;
  switch (shape) {
    case Shape::parallelogram:
      s.position = a + u * b + v * c;
      s.area = b.cross(c);
      break;
    case Shape::triangle:
      s.position = a + u * (b + v * (c - b));
      s.area = u * b.cross(c);
      break;
    case Shape::segment:
      s.position = a + u * b;
      s.current = current * b;
      break;
    case Shape::side: {
      const Vec3 normal(cosine, sine, 0.0);
      const double area = radius1 * turn * (height1 - height0);
      s.position = radius1 * normal + Vec3(0.0, 0.0, height0 + v * (height1 - height0));
      s.area = sign * area * normal;
      s.current = current * area * Vec3(-sine, cosine, 0.0);
      break;
    }
    case Shape::disc: {
      const double inner = reach(0, cosine, sine), outer = reach(1, cosine, sine);
      const double rho = inner + v * (outer - inner);
      s.position = Vec3(rho * cosine, rho * sine, height0);
      s.area.z() = sign * rho * turn * (outer - inner);
      break;
    }
    case Shape::circle:
      s.position = radius1 * Vec3(cosine, sine, 0.0);
      s.current = current * radius1 * turn * Vec3(-sine, cosine, 0.0);
      break;
  }
  s.charge = s.area.dot(magnetization);
  return s;
}

}  // namespace loomstone
