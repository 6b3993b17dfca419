#include "core/magnetics/forces/cut_panels.h"

#include <algorithm>
#include <array>
#include <numeric>

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

}  // namespace loomstone
