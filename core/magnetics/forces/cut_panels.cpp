#include "core/magnetics/forces/cut_panels.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

using Polygon = std::vector<Vec3>;

// Parts of a convex polygon on the two sides of a plane. `behind` is empty if no corner has a
// negative height above the plane, and `ahead` is empty if no corner has a positive one.
struct PolygonHalves {
  Polygon behind, ahead;
};

// `heights` contains the heights of the corners of `polygon` above the plane.
PolygonHalves halves_of(const Polygon& polygon, const std::vector<double>& heights) {
  PolygonHalves halves;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const std::size_t next = (k + 1) % polygon.size();
    const double here = heights[k], there = heights[next];
    if (here <= 0.0) halves.behind.push_back(polygon[k]);
    if (here >= 0.0) halves.ahead.push_back(polygon[k]);
    if (here * there >= 0.0) continue;
    const Vec3 crossing = polygon[k] + here / (here - there) * (polygon[next] - polygon[k]);
    halves.behind.push_back(crossing);
    halves.ahead.push_back(crossing);
  }
  const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
  if (*low >= 0.0) halves.behind.clear();
  if (*high <= 0.0) halves.ahead.clear();
  return halves;
}

Polygon corners_of(const Panel& panel) {
  if (panel.shape == Panel::Shape::triangle) return {panel.a, panel.a + panel.b, panel.a + panel.c};
  return {panel.a, panel.a + panel.b, panel.a + panel.b + panel.c, panel.a + panel.c};
}

}  // namespace

std::vector<Panel> cut_along_faces(const Panel& panel, const RigidPose& pose,
                                   const UniformCuboid& cuboid) {
  const Mat3 rotation = rotation_matrix(pose.orientation);
  // A plane to which the panel is closer than this does not cut it [m].
  const double flush = 1e-9 * cuboid.size.norm();
  std::vector<Polygon> pieces{corners_of(panel)}, parts;
  for (const int axis : {0, 1, 2})
    for (const double side : {-0.5, 0.5}) {
      parts.clear();
      for (Polygon& piece : pieces) {
        std::vector<double> heights;
        for (const Vec3& x : piece)
          heights.push_back((pose.position + rotation * x)[axis] - side * cuboid.size[axis]);
        const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
        if (*low > -flush || *high < flush) {
          parts.push_back(std::move(piece));
          continue;
        }
        PolygonHalves halves = halves_of(piece, heights);
        parts.push_back(std::move(halves.behind));
        parts.push_back(std::move(halves.ahead));
      }
      pieces.swap(parts);
    }
  std::vector<Panel> triangles;
  for (const Polygon& piece : pieces) {
    const Vec3 middle =
        std::accumulate(piece.begin(), piece.end(), Vec3(0.0, 0.0, 0.0)) / double(piece.size());
    for (std::size_t k = 0; k < piece.size(); ++k) {
      Panel triangle = panel;
      triangle.shape = Panel::Shape::triangle;
      triangle.a = middle;
      triangle.b = piece[k] - middle;
      triangle.c = piece[(k + 1) % piece.size()] - middle;
      triangles.push_back(triangle);
    }
  }
  return triangles;
}

std::vector<Panel> cut_along_rims(const Panel& panel, const RigidPose& pose,
                                  const UniformCylinder& cylinder) {
  constexpr double least_cosine = 0.996;  // of the angle between the axes
  const Mat3 to_disc = rotation_matrix(pose.orientation).transpose();
  const Vec3 axis = to_disc.col(2), through = -to_disc * pose.position;
  if (std::abs(axis.z()) < least_cosine) return {};
  Panel whole = panel;
  whole.a = through + (panel.height0 - through.z()) / axis.z() * axis;
  const double off = std::hypot(whole.a.x(), whole.a.y()),
               towards = std::atan2(whole.a.y(), whole.a.x());
  std::vector<double> rims;  // radii, in ascending order
  for (const double rim : {cylinder.inner_radius, cylinder.radius})
    if (rim > off) rims.push_back(rim);
  if (rims.empty()) return {};
  // A rim crosses a boundary of the disc at up to two azimuths.
  std::vector<double> azimuths{panel.azimuth, panel.azimuth + panel.turn};
  for (const double rim : rims)
    for (const double radius : {panel.radius0, panel.radius1}) {
      const double cosine = (radius * radius + off * off - rim * rim) / (2.0 * radius * off);
      if (!(std::abs(cosine) < 1.0)) continue;
      for (const double away : {std::acos(cosine), -std::acos(cosine)}) {
        const double turns = (towards + away - panel.azimuth) / (2.0 * pi);
        const double phi = panel.azimuth + 2.0 * pi * (turns - std::floor(turns));
        if (phi < panel.azimuth + panel.turn) azimuths.push_back(phi);
      }
    }
  std::sort(azimuths.begin(), azimuths.end());
  std::vector<Panel> parts;
  for (std::size_t k = 0; k + 1 < azimuths.size(); ++k) {
    Panel part = whole;
    part.azimuth = azimuths[k], part.turn = azimuths[k + 1] - azimuths[k];
    if (part.turn <= 0.0) continue;
    for (const double rim : rims) {
      const double there = part.reach(rim, part.azimuth + 0.5 * part.turn);
      if (there <= panel.radius0 || there >= panel.radius1) continue;
      part.circle1 = rim;
      parts.push_back(part);
      part.circle0 = rim, part.circle1 = 0.0;
    }
    parts.push_back(part);
  }
  return parts;
}

}  // namespace loomstone
