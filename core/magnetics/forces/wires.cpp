#include "core/magnetics/forces/wires.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace loomstone {

namespace {

// Returns the distance of a point from a segment, or from the full circle of an arc [m]. The point
// is given in the axes of the line's source.
double distance_to(const Panel& line, const Vec3& point) {
  if (line.shape == Panel::Shape::circle)
    return std::hypot(std::hypot(point.x(), point.y()) - line.radius1, point.z());
  const double along = (point - line.a).dot(line.b) / line.b.squaredNorm();
  return (point - line.a - std::clamp(along, 0.0, 1.0) * line.b).norm();
}

double length_of(const Panel& line) {
  return line.shape == Panel::Shape::circle ? std::abs(line.turn) * line.radius1 : line.b.norm();
}

// Part of a segment or arc, given by the range of the parameter u of Panel::at().
struct Part {
  const Panel* line;
  double begin, end;
};

}  // namespace

bool wires_meet(const MagneticBody& a, const MagneticBody& b) {
  const std::vector<Panel> mine = a.source->panels(), others = b.source->panels();
  const auto line = [](const Panel& panel) { return panel.line(); };
  if (mine.empty() || others.empty() || !std::all_of(mine.begin(), mine.end(), line) ||
      !std::all_of(others.begin(), others.end(), line))
    return false;
  const RigidPose pose = relative_pose(a.pose, b.pose);
  const Mat3 rotation = rotation_matrix(pose.orientation);
  const double near = 1e-6 * (a.source->radius() + b.source->radius());
  std::vector<Part> open;
  for (const Panel& part : mine) open.push_back({&part, 0.0, 1.0});
  while (!open.empty()) {
    const Part part = open.back();
    open.pop_back();
    const double middle = 0.5 * (part.begin + part.end);
    const Vec3 point = pose.position + rotation * part.line->at(middle, 0.5).position;
    double distance = std::numeric_limits<double>::infinity();
    for (const Panel& other : others) distance = std::min(distance, distance_to(other, point));
    if (distance <= near) return true;
    // No point of the part is closer to the other wire than `distance` minus half the part's
    // length.
    if (distance > 0.5 * (part.end - part.begin) * length_of(*part.line) + near) continue;
    open.push_back({part.line, part.begin, middle});
    open.push_back({part.line, middle, part.end});
  }
  return false;
}

}  // namespace loomstone
