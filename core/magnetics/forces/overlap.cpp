#include "core/magnetics/forces/overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/message.h"
#include "core/magnetics/forces/wires.h"

namespace loomstone {

namespace {

struct OrientedBox {
  Vec3 centre, half;
  Mat3 axes;  // unit vectors along the edges, as columns
};

OrientedBox box_of(const MagneticBody& body) {
  const auto [low, high] = *body.source->box();
  const Mat3 axes = rotation_matrix(body.pose.orientation);
  return {body.pose.position + axes * (0.5 * (low + high)), 0.5 * (high - low), axes};
}

// Returns the largest gap between the projections of two boxes onto any axis of the separating-axis
// test [m]. These axes are the face normals and the cross products of edges. The largest gap is
// negative if the boxes overlap.
double separation(const OrientedBox& a, const OrientedBox& b) {
  constexpr double parallel = 1e-6;  // sine of the angle below which edges count as parallel
  const Vec3 away = b.centre - a.centre;
  double largest = -std::numeric_limits<double>::infinity();
  const auto project = [&](const Vec3& axis) {
    const double gap = std::abs(away.dot(axis)) -
                       (a.axes.transpose() * axis).cwiseAbs().dot(a.half) -
                       (b.axes.transpose() * axis).cwiseAbs().dot(b.half);
    largest = std::max(largest, gap);
  };
  for (int i = 0; i < 3; ++i) {
    project(a.axes.col(i));
    project(b.axes.col(i));
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis = a.axes.col(i).cross(b.axes.col(k));
      if (axis.norm() > parallel) project(axis.normalized());
    }
  }
  return largest;
}

// Returns whether any point of a lattice on the surface of `one` lies deeper than `rounding` [m]
// inside `other`.
bool enters(const MagneticBody& one, const MagneticBody& other, double rounding) {
  const std::vector<Panel> surface = one.source->surface();
  const int parts =
      std::max(2, static_cast<int>(16.0 / std::sqrt(static_cast<double>(surface.size()))));
  const RigidPose pose = relative_pose(one.pose, other.pose);
  const Mat3 rotation = rotation_matrix(pose.orientation);
  for (const Panel& panel : surface) {
    for (int i = 0; i <= parts; ++i) {
      for (int k = 0; k <= parts; ++k) {
        const Vec3 point =
            panel.at(static_cast<double>(i) / parts, static_cast<double>(k) / parts).position;
        if (other.source->depth(pose.position + rotation * point) > rounding) return true;
      }
    }
  }
  return false;
}

}  // namespace

bool overlap(const MagneticBody& a, const MagneticBody& b) {
  if (!a.source->box() || !b.source->box()) return false;
  const double size = a.source->radius() + b.source->radius(), rounding = 1e-6 * size;
  if ((b.pose.position - a.pose.position).norm() > size) return false;
  for (const auto& [ball, other] : {std::pair(&a, &b), std::pair(&b, &a)})
    if (ball->source->spherical())
      return other->source->depth(in_axes(other->pose, ball->pose.position)) >
             rounding - ball->source->radius();
  if (separation(box_of(a), box_of(b)) > -rounding) return false;
  if (a.source->uniform_cuboid() && b.source->uniform_cuboid()) return true;
  return enters(a, b, rounding) || enters(b, a, rounding);
}

Vec3 outward_normal(const Source& solid, const Vec3& point) {
  // The normal is minus the gradient of the depth, here by central differences.
  const double reach = 1e-6 * solid.radius();
  Vec3 outward;
  for (int c = 0; c < 3; ++c) {
    const Vec3 step = reach * Vec3::Unit(c);
    outward[c] = solid.depth(point - step) - solid.depth(point + step);
  }
  return outward.isZero(0.0) ? outward : outward.normalized();
}

Vec3 moved_outside(const Source& solid, const Vec3& point) {
  const auto box = solid.box();
  if (!box || (point - box->first).minCoeff() < 0.0 || (box->second - point).minCoeff() < 0.0)
    return point;
  const double depth = solid.depth(point);
  if (depth < 0.0) return point;
  // Distance above the surface [m]. It far exceeds the rounding errors of distances in the closed
  // forms of the field.
  const double above = 1e-9 * solid.radius();
  return point + (depth + above) * outward_normal(solid, point);
}

void check_no_overlap(const std::vector<MagneticBody>& bodies,
                      const std::vector<std::string>& names) {
  // Pairs are found by sweeping along x. Bounding spheres are enlarged by a margin, so that wires
  // that only touch each other are tested, too. `left` contains the smallest x of each sphere [m].
  constexpr double with_margin = 1.0 + 1e-5;
  std::vector<double> left;
  for (const MagneticBody& body : bodies)
    left.push_back(body.pose.position.x() - with_margin * body.source->radius());
  std::vector<std::size_t> order(bodies.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t k) {
    return std::pair(left[i], i) < std::pair(left[k], k);
  });
  std::vector<std::pair<std::size_t, std::size_t>> found;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const MagneticBody& body = bodies[order[i]];
    const double right = body.pose.position.x() + with_margin * body.source->radius();
    for (std::size_t k = i + 1; k < order.size() && left[order[k]] < right; ++k)
      if (overlap(body, bodies[order[k]]) || wires_meet(body, bodies[order[k]]))
        found.push_back(std::minmax(order[i], order[k]));
  }
  if (found.empty()) return;
  const auto [first, second] = *std::min_element(found.begin(), found.end());
  if (wires_meet(bodies[first], bodies[second]))
    fail<InvalidInput>(
        "thin wires must lie apart, because the force between them is infinite where they meet, "
        "but {} meets {}; move one of them",
        names[first], names[second]);
  fail<InvalidInput>("magnets must lie apart to exert forces, but {} overlaps {}; move one of them",
                     names[first], names[second]);
}

}  // namespace loomstone
