// Fits the camera so that every corner of the framing box projects into the picture. In camera
// coordinates (a right, b up, c into the picture), a point is within the picture horizontally if
// |a - eye_a| <= t (c - eye_c), where t is the tangent of half the angle of view, reduced by a
// margin. All corners together restrict (eye_a, eye_c) to the intersection of two half-planes,
// whose corner is the closest possible eye. The vertical direction is analogous; the eye takes the
// larger of the two distances.
#include "renderer/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace loomstone {
namespace {

constexpr double margin = 0.92;  // fraction of the picture that the box may fill (our choice)
constexpr double pi = 3.14159265358979323846;

void include(const Points& positions, Index vertex, Framing& box) {
  box.low = box.low.cwiseMin(positions.row(vertex).transpose());
  box.high = box.high.cwiseMax(positions.row(vertex).transpose());
}

}  // namespace

Framing make_framing(const FrameTopology& topology, const Frame& first) {
  const double infinity = std::numeric_limits<double>::infinity();
  Framing box{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  for (Index vertex = 0; vertex < first.positions.rows(); ++vertex)
    include(first.positions, vertex, box);
  const Framing cloth = box;
  double floor_height = -infinity;
  for (Index vertex = 0; vertex < first.body_vertices.rows(); ++vertex) {
    if (topology.body_is_floor[topology.body_of_vertex[vertex]])
      floor_height = std::max(floor_height, first.body_vertices(vertex, 2));
    else
      include(first.body_vertices, vertex, box);
  }
  if (!(box.low.array() <= box.high.array()).all())
    return {Vec3::Constant(-0.5), Vec3::Constant(0.5)};
  if (first.positions.rows() > 0) {
    const double fall = std::max(cloth.high.x() - cloth.low.x(), cloth.high.y() - cloth.low.y());
    const double lowest = std::max(cloth.high.z() - fall, floor_height);
    if (lowest < box.low.z()) box.low.z() = lowest;
  }
  // Shortest edge that the box may have, even if its contents are flat or a single point [m].
  const double least = std::max(1e-6, 0.02 * (box.high - box.low).norm());
  for (int axis = 0; axis < 3; ++axis) {
    const double missing = std::max(0.0, least - (box.high[axis] - box.low[axis]));
    box.low[axis] -= 0.5 * missing;
    box.high[axis] += 0.5 * missing;
  }
  return box;
}

Vec3 viewing_direction(const Camera& camera) {
  const Vec3 given = camera.eye - camera.target;
  return given.norm() > 0.0 ? Vec3(given.normalized()) : Vec3(0.62, -1.0, 0.44).normalized();
}

View make_view(const Camera& camera, double aspect, const Framing& framing) {
  View view;
  view.tangent_y = std::tan(0.5 * camera.field_of_view_degrees * pi / 180.0);
  view.tangent_x = view.tangent_y * aspect;
  view.forward = -viewing_direction(camera);
  view.right = view.forward.cross(camera.up).normalized();
  view.up = view.right.cross(view.forward);
  view.eye = camera.eye;
  if (camera.fit) {
    // Maxima of -a - t c (low) and a - t c (high) over the corners of the box, with a, b, c and t
    // as at the top of this file. The vertical direction has b in place of a.
    std::array<double, 2> low, high;
    low.fill(-std::numeric_limits<double>::infinity());
    high = low;
    const std::array<double, 2> tangent = {margin * view.tangent_x, margin * view.tangent_y};
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 p(corner & 1 ? framing.high.x() : framing.low.x(),
                   corner & 2 ? framing.high.y() : framing.low.y(),
                   corner & 4 ? framing.high.z() : framing.low.z());
      const std::array<double, 2> across = {p.dot(view.right), p.dot(view.up)};
      for (int axis = 0; axis < 2; ++axis) {
        high[axis] = std::max(high[axis], across[axis] - tangent[axis] * p.dot(view.forward));
        low[axis] = std::max(low[axis], -across[axis] - tangent[axis] * p.dot(view.forward));
      }
    }
    const double depth = std::min(-(high[0] + low[0]) / (2.0 * tangent[0]),
                                  -(high[1] + low[1]) / (2.0 * tangent[1]));
    view.eye = 0.5 * (high[0] - low[0]) * view.right + 0.5 * (high[1] - low[1]) * view.up +
               depth * view.forward;
  }
  const double distance = (framing.centre() - view.eye).dot(view.forward);
  view.near_depth = std::max(0.02 * framing.radius(), distance - 8.0 * framing.radius());
  view.far_depth = std::max(distance, 0.0) + 20.0 * framing.radius();
  return view;
}

Float4x4 View::view() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.block<1, 3>(0, 0) = right.transpose();
  m.block<1, 3>(1, 0) = up.transpose();
  m.block<1, 3>(2, 0) = -forward.transpose();
  m(0, 3) = -right.dot(eye);
  m(1, 3) = -up.dot(eye);
  m(2, 3) = forward.dot(eye);
  return m.cast<float>();
}

Float4x4 View::projection() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(0, 0) = 1.0 / tangent_x;
  m(1, 1) = 1.0 / tangent_y;
  m(2, 2) = -(far_depth + near_depth) / (far_depth - near_depth);
  m(2, 3) = -2.0 * far_depth * near_depth / (far_depth - near_depth);
  m(3, 2) = -1.0;
  return m.cast<float>();
}

}  // namespace loomstone
