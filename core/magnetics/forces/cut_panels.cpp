#include "core/magnetics/forces/cut_panels.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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

// A curve that cuts a disc: the circle of radius `radius` [m] about Panel::a or, if `radius` is 0,
// the line whose point nearest to the axis of the disc is `nearest` (see Panel::line0).
struct Curve {
  double radius;
  Vec3 nearest;
};

// The cuts of a disc: curves, and azimuths [rad]. The azimuths are those at which the disc begins
// and ends, those at which curves cross each other or the boundaries of the disc, and those of the
// two directions of each straight line. Between neighbouring azimuths, the curves keep their order
// along the radius.
class DiscCuts {
 public:
  explicit DiscCuts(const Panel& whole)
      : whole_(whole), azimuths_{whole.azimuth, whole.azimuth + whole.turn} {}

  void add_curve(const Curve& curve) { curves_.push_back(curve); }
  // Adds the azimuth `azimuth` modulo a turn, if the disc contains it.
  void add_azimuth(double azimuth) {
    const double turns = (azimuth - whole_.azimuth) / (2.0 * pi);
    const double phi = whole_.azimuth + 2.0 * pi * (turns - std::floor(turns));
    if (phi < whole_.azimuth + whole_.turn) azimuths_.push_back(phi);
  }
  // Adds the two azimuths whose angle to `towards` has the given cosine, if there are any.
  void add_azimuths(double towards, double cosine) {
    if (!(std::abs(cosine) < 1.0)) return;
    for (const double away : {std::acos(cosine), -std::acos(cosine)}) add_azimuth(towards + away);
  }

  std::vector<Panel> parts() {
    std::sort(azimuths_.begin(), azimuths_.end());
    std::vector<Panel> parts;
    for (std::size_t k = 0; k + 1 < azimuths_.size(); ++k) {
      Panel part = whole_;
      part.azimuth = azimuths_[k], part.turn = azimuths_[k + 1] - azimuths_[k];
      if (part.turn > 0.0) add_parts(part, parts);
    }
    return parts;
  }

 private:
  // Adds the parts between the curves that cross the sector `part`.
  void add_parts(Panel part, std::vector<Panel>& parts) const {
    const double middle = part.azimuth + 0.5 * part.turn, cosine = std::cos(middle),
                 sine = std::sin(middle);
    std::vector<std::pair<double, std::size_t>> crossing;
    for (std::size_t i = 0; i < curves_.size(); ++i) {
      Panel beyond = part;
      set_inner(curves_[i], beyond);
      const double reach = beyond.reach(0, cosine, sine);
      if (reach > whole_.radius0 && reach < whole_.radius1) crossing.emplace_back(reach, i);
    }
    std::sort(crossing.begin(), crossing.end());
    for (const auto& [reach, i] : crossing) {
      Panel inside = part;
      inside.circle1 = curves_[i].radius, inside.line1 = curves_[i].nearest;
      parts.push_back(inside);
      set_inner(curves_[i], part);
    }
    parts.push_back(part);
  }
  static void set_inner(const Curve& curve, Panel& part) {
    part.circle0 = curve.radius, part.line0 = curve.nearest;
  }

  Panel whole_;
  std::vector<Curve> curves_;
  std::vector<double> azimuths_;
};

}  // namespace

std::vector<Panel> cut_along_faces(const Panel& panel, const RigidPose& pose,
                                   const UniformCuboid& cuboid) {
  const Mat3 rotation = rotation_matrix(pose.orientation);
  // A plane cuts a piece only if the piece extends at least this far on both sides of the plane
  // [m].
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
  DiscCuts cuts(whole);
  bool any = false;
  for (const double rim : {cylinder.inner_radius, cylinder.radius}) {
    if (!(rim > off)) continue;
    any = true;
    cuts.add_curve({rim, Vec3::Zero()});
    for (const double radius : {panel.radius0, panel.radius1})
      cuts.add_azimuths(towards, (radius * radius + off * off - rim * rim) / (2.0 * radius * off));
  }
  return any ? cuts.parts() : std::vector<Panel>();
}

std::vector<Panel> cut_disc_along_faces(const Panel& panel, const RigidPose& pose,
                                        const UniformCuboid& cuboid) {
  const Mat3 rotation = rotation_matrix(pose.orientation);
  DiscCuts cuts(panel);
  std::vector<Vec3> lines;
  for (const int axis : {0, 1, 2})
    for (const double side : {-0.5, 0.5}) {
      // In the axes of the disc, with the origin at its centre, the plane is the set of all x with
      // normal . x = offset.
      const Vec3 normal = rotation.row(axis).transpose(), across(normal.x(), normal.y(), 0.0);
      const double offset =
          side * cuboid.size[axis] - pose.position[axis] - normal.z() * panel.height0;
      const double slope = across.norm(), away = std::abs(offset) / slope;
      if (!(away < panel.radius1)) continue;
      const double towards = std::atan2(across.y(), across.x()) + (offset < 0.0 ? pi : 0.0);
      for (const double radius : {panel.radius0, panel.radius1})
        cuts.add_azimuths(towards, away / radius);
      cuts.add_azimuths(towards, 0.0);
      // A line through the axis of the disc coincides with borders of sectors, so it crosses none.
      if (away < 1e-9 * panel.radius1) continue;
      lines.push_back(offset / (slope * slope) * across);
      cuts.add_curve({0.0, lines.back()});
    }
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      // The common point x of both lines satisfies p . x = |p|^2 for p = lines[i] and p = lines[j].
      const Vec3 &p = lines[i], &q = lines[j];
      const double area = p.x() * q.y() - p.y() * q.x();
      if (area == 0.0) continue;
      const double pp = p.squaredNorm(), qq = q.squaredNorm(), x = (pp * q.y() - qq * p.y()) / area,
                   y = (qq * p.x() - pp * q.x()) / area;
      if (std::hypot(x, y) < panel.radius1) cuts.add_azimuth(std::atan2(y, x));
    }
  return cuts.parts();
}

}  // namespace loomstone
