// Fits the camera so that every given point projects into the picture. In camera coordinates (a
// right, b up, c into the picture), a point is within the picture horizontally if |a - eye_a| <= t
// (c - eye_c), where t is the tangent of half the angle of view, reduced by a margin. The largest
// values of a - t c and of -a - t c over all points restrict (eye_a, eye_c) to the intersection of
// two half-planes, whose corner is the closest possible eye. The vertical direction is analogous.
// The eye is placed at the larger of the distances that the two directions require. In the
// direction that requires the smaller distance, the points are then centred in the picture. If the
// camera turns, the largest values are taken over the circles on which the points move relative to
// the camera, so that the distance is the same for all angles of the turn.
#include "renderer/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/keyframes.h"
#include "core/base/message.h"
#include "renderer/check.h"
#include "renderer/scalar_field.h"
#include "renderer/visible.h"

namespace loomstone {
namespace {

// Fraction of the width and height of the picture that the points may fill.
constexpr double margin = 0.92;
constexpr double pi = 3.14159265358979323846;

void include(const Vec3& point, Framing& framing) {
  framing.low = framing.low.cwiseMin(point);
  framing.high = framing.high.cwiseMax(point);
  framing.points.push_back(point);
}

// Extends `framing` to the cloth and to the visible bodies and obstacles other than floors. Returns
// the height of the highest floor vertex [m], or minus infinity if there is no floor.
double include_surfaces(const FrameTopology& topology, const Frame& frame, Framing& framing) {
  for (Index vertex = 0; vertex < frame.positions.rows(); ++vertex)
    include(frame.positions.row(vertex), framing);
  double floor_height = -std::numeric_limits<double>::infinity();
  std::vector<std::uint8_t> drawn(static_cast<std::size_t>(frame.body_vertices.rows()), 0);
  for (const Index vertex : topology.body_triangles.reshaped())
    drawn[static_cast<std::size_t>(vertex)] = 1;
  for (Index vertex = 0; vertex < frame.body_vertices.rows(); ++vertex) {
    if (topology.body_is_floor[topology.body_of_vertex[vertex]])
      floor_height = std::max(floor_height, frame.body_vertices(vertex, 2));
    else if (drawn[static_cast<std::size_t>(vertex)])
      include(frame.body_vertices.row(vertex), framing);
  }
  return floor_height;
}

Framing nothing() {
  const double infinity = std::numeric_limits<double>::infinity();
  return {Vec3::Constant(infinity), Vec3::Constant(-infinity)};
}

// Enlarges the box so that each edge is at least 1e-6 m long, and at least 2 % of the original
// length of the diagonal. A box without points becomes a cube with edges of 1 m about the origin.
void widen(Framing& framing) {
  if (!(framing.low.array() <= framing.high.array()).all()) {
    framing.low = Vec3::Constant(-0.5);
    framing.high = Vec3::Constant(0.5);
  }
  const double least = std::max(1e-6, 0.02 * (framing.high - framing.low).norm());
  for (int axis = 0; axis < 3; ++axis) {
    const double missing = std::max(0.0, least - (framing.high[axis] - framing.low[axis]));
    framing.low[axis] -= 0.5 * missing;
    framing.high[axis] += 0.5 * missing;
  }
}

// Eye and target of the camera at one time. If the eye or the target has keyframes, it moves along
// a cubic spline through them (E. Catmull, R. Rom, "A class of local interpolating splines", 1974).
// If the camera has no keyframes, the eye only gives the viewing direction: it is 1 m from the
// target.
struct Sight {
  Vec3 eye, target;
};

Vec3 on_path(const std::vector<double>& times, const Points& points, double time) {
  const Keyframes at = keyframes_at(times, time);
  if (at.first == at.second) return points.row(static_cast<Index>(at.first));
  const Vec3 from = points.row(static_cast<Index>(at.first)),
             to = points.row(static_cast<Index>(at.second));
  const auto slope = [&](std::size_t key) -> Vec3 {
    const std::size_t before = key == 0 ? 0 : key - 1, after = std::min(key + 1, times.size() - 1);
    return (points.row(static_cast<Index>(after)) - points.row(static_cast<Index>(before))) /
           (times[after] - times[before]);
  };
  const double s = at.fraction, step = times[at.second] - times[at.first];
  return (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s) * from + s * s * (3.0 - 2.0 * s) * to +
         step * s * (1.0 - s) * ((1.0 - s) * slope(at.first) - s * slope(at.second));
}

Sight sight(const Camera& camera, double time) {
  if (camera.times.empty()) return {camera.target + viewing_direction(camera), camera.target};
  const Vec3 target =
      camera.targets.rows() > 0 ? on_path(camera.times, camera.targets, time) : camera.target;
  return {on_path(camera.times, camera.eyes, time), target};
}

// Evaluates linear functionals at points. If the camera turns, a point moves on a circle relative
// to the camera, and the result is the largest value on this circle.
class Support {
 public:
  Support(const Camera& camera, const Framing& framing)
      : turns_(camera.turn != 0.0), axis_(camera.up.normalized()), centre_(framing.centre()) {}
  double value(const Vec3& functional, const Vec3& point) const {
    if (!turns_) return functional.dot(point);
    const Vec3 arm = point - centre_;
    const double along = arm.dot(axis_), rise = functional.dot(axis_);
    return functional.dot(centre_) + along * rise +
           (arm - along * axis_).norm() * (functional - rise * axis_).norm();
  }

 private:
  bool turns_;
  Vec3 axis_, centre_;
};

// Two linear functionals of a point. Their largest values over all points bound the position of the
// eye along `axis` and along `forward`. Within these bounds, the distance of each point from the
// eye along `axis` is at most `slope` times that along `forward`.
std::array<Vec3, 2> functionals(const Vec3& axis, const Vec3& forward, double slope) {
  return {axis - slope * forward, -axis - slope * forward};
}

std::vector<Vec3> box_corners(const Framing& framing) {
  std::vector<Vec3> corners;
  for (int corner = 0; corner < 8; ++corner)
    corners.emplace_back(corner & 1 ? framing.high.x() : framing.low.x(),
                         corner & 2 ? framing.high.y() : framing.low.y(),
                         corner & 4 ? framing.high.z() : framing.low.z());
  return corners;
}

// Fraction of the width that points may fill if a legend takes the fraction `legend` of it at one
// side. Because the points are centred, as much is left empty at the other side.
double margin_beside(double legend) { return std::min(margin, 0.99 - 2.0 * legend); }

// Moves the eye as close to the points as the margins and a legend permit, and centres the points
// in the picture.
void fit(const Camera& camera, const Framing& framing, double legend, View& view) {
  const Support support(camera, framing);
  const std::vector<Vec3> points = framing.points.empty() ? box_corners(framing) : framing.points;
  const auto most = [&](const Vec3& axis, double slope) {
    std::array<double, 2> largest;
    largest.fill(-std::numeric_limits<double>::infinity());
    const std::array<Vec3, 2> functional = functionals(axis, view.forward, slope);
    for (const Vec3& point : points)
      for (std::size_t k = 0; k < 2; ++k)
        largest[k] = std::max(largest[k], support.value(functional[k], point));
    return largest;
  };
  const auto depth_of = [](const std::array<double, 2>& largest, double slope) {
    return -(largest[0] + largest[1]) / (2.0 * slope);
  };
  const double slope_x = margin_beside(legend) * view.tangent_x, slope_y = margin * view.tangent_y;
  const double depth = std::min(depth_of(most(view.right, slope_x), slope_x),
                                depth_of(most(view.up, slope_y), slope_y));
  Vec3 eye = depth * view.forward;
  for (const auto& [axis, slope] : {std::pair(view.right, slope_x), std::pair(view.up, slope_y)}) {
    // Bisection finds the smallest slope with which all points are in the picture from this depth.
    // After 50 halvings, the interval is as small as rounding errors.
    double low = 0.0, high = slope;
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (depth_of(most(axis, middle), middle) < depth ? low : high) = middle;
    }
    const std::array<double, 2> largest = most(axis, high);
    eye += 0.5 * (largest[0] - largest[1]) * axis;
  }
  view.eye = eye;
}

// Returns a view from the eye to the target of `sight`.
View aimed(const Camera& camera, double aspect, const Sight& sight) {
  View view;
  view.tangent_y = std::tan(0.5 * camera.field_of_view_degrees * pi / 180.0);
  view.tangent_x = view.tangent_y * aspect;
  view.forward = (sight.target - sight.eye).normalized();
  view.right = view.forward.cross(camera.up).normalized();
  view.up = view.right.cross(view.forward);
  view.eye = sight.eye;
  return view;
}

// Rotates a view by an angle [rad] about an axis through `centre`.
void turn(const Vec3& centre, const Vec3& axis, double angle, View& view) {
  const Mat3 rotation = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  view.eye = centre + rotation * (view.eye - centre);
  for (Vec3* direction : {&view.right, &view.up, &view.forward}) *direction = rotation * *direction;
}

// Checks the topology and the options. Returns the topology without hidden bodies and obstacles.
FrameTopology checked(const FrameTopology& topology, const RenderOptions& options) {
  check_topology(topology);
  check_options(options, 8, 16384);
  check_hidden(topology, options);
  return shown(topology, options);
}

}  // namespace

Framing make_framing(const FrameTopology& topology, const Frame& first) {
  Framing framing = nothing();
  const double floor_height = include_surfaces(topology, first, framing);
  if (first.positions.rows() > 0) {
    const Vec3 low = first.positions.colwise().minCoeff(),
               high = first.positions.colwise().maxCoeff();
    const double fall = (high - low).head<2>().maxCoeff();
    const double lowest = std::max(high.z() - fall, floor_height);
    if (lowest < framing.low.z())
      for (const double x : {low.x(), high.x()})
        for (const double y : {low.y(), high.y()}) include(Vec3(x, y, lowest), framing);
  }
  widen(framing);
  return framing;
}

double legend_width(int height) { return 5.7 * std::max(11.0, 0.026 * height); }

double legend_share(const RenderOptions& options) {
  const std::vector<std::string> rows = names_in(options.color_by);
  if (std::all_of(rows.begin(), rows.end(), [](const auto& row) { return row == "cloth"; }))
    return 0.0;
  return std::min(0.3, legend_width(options.height) / options.width);
}

Vec3 viewing_direction(const Camera& camera) {
  const Vec3 given = camera.eye - camera.target;
  return given.norm() > 0.0 ? Vec3(given.normalized()) : Vec3(0.62, -1.0, 0.44).normalized();
}

View make_view(const Camera& camera, double aspect, const Framing& framing, double time,
               double legend) {
  const Sight here = sight(camera, time);
  View view = aimed(camera, aspect, here);
  if (camera.times.empty()) view.eye = camera.eye;
  if (fits(camera)) fit(camera, framing, legend, view);
  if (camera.turn != 0.0)
    turn(fits(camera) ? framing.centre() : here.target, camera.up, camera.turn * time * pi / 180.0,
         view);
  const double distance = (framing.centre() - view.eye).dot(view.forward);
  view.near_depth = std::max(0.02 * framing.radius(), distance - 8.0 * framing.radius());
  view.far_depth = std::max(distance, 0.0) + 20.0 * framing.radius();
  return view;
}

CameraFit::CameraFit(const FrameTopology& topology, const RenderOptions& options)
    : topology_(checked(topology, options)),
      camera_(options.camera),
      aspect_(static_cast<double>(options.width) / options.height),
      legend_(legend_share(options)),
      framing_(nothing()) {
  require(camera_.times.empty(),
          "a camera with keyframes cannot be fitted; leave out its times, or the fit");
  camera_.fit = true;
}

void CameraFit::include(const Frame& frame) {
  check_frame(topology_, RenderOptions{}, frame);
  Framing now = nothing();
  include_surfaces(topology_, frame, now);
  if (framing_.points.empty()) {
    framing_ = now;
    widen(framing_);
  } else {
    framing_.points.insert(framing_.points.end(), now.points.begin(), now.points.end());
  }
  if (framing_.points.empty()) return;
  // Only the points that bound the position of the eye are kept. If these are visible, all points
  // are.
  const Support support(camera_, framing_);
  std::vector<Vec3> outermost;
  const View view = aimed(camera_, aspect_, sight(camera_, 0.0));
  for (const auto& [axis, slope] : {std::pair(view.right, margin_beside(legend_) * view.tangent_x),
                                    std::pair(view.up, margin * view.tangent_y)})
    for (const Vec3& functional : functionals(axis, view.forward, slope))
      outermost.push_back(*std::max_element(
          framing_.points.begin(), framing_.points.end(), [&](const Vec3& a, const Vec3& b) {
            return support.value(functional, a) < support.value(functional, b);
          }));
  framing_.points = outermost;
}

Camera CameraFit::camera() const {
  const View view = make_view(camera_, aspect_, framing_, 0.0, legend_);
  Camera fitted = camera_;
  fitted.fit = false;
  fitted.eye = view.eye;
  // If the camera turns, its target lies on the axis of the turn.
  Vec3 across = view.forward;
  if (camera_.turn != 0.0) {
    const Vec3 axis = camera_.up.normalized();
    across -= across.dot(axis) * axis;
  }
  const double distance = (framing_.centre() - view.eye).dot(across) / across.squaredNorm();
  fitted.target = view.eye + distance * view.forward;
  return fitted;
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
