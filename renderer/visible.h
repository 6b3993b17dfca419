// Visible parts of a scene: bodies and obstacles that are not hidden, planes and uv of floors, and
// the rectangle of the picture that encloses given points.
#pragma once

#include <vector>

#include "core/base/frame.h"
#include "renderer/camera.h"
#include "renderer/render_options.h"

namespace loomstone {

// Returns the topology without the triangles of hidden bodies and obstacles. Their vertices remain,
// so that frames still match the topology. Hidden floors do not count as floors.
FrameTopology shown(const FrameTopology& topology, const RenderOptions& options);

// Returns the vertices of the triangles of bodies and obstacles other than floors, in ascending
// order.
std::vector<Index> casting_vertices(const FrameTopology& topology);

// The plane of a floor: the mean of its triangles' corners, and the upward mean normal of the
// triangles. Both are zero if there are no triangles or their mean normal is zero.
struct Plane {
  Vec3 point, normal;
};
Plane floor_plane(const FrameTopology& topology, const Points& x, Index body);

// Affine function of position, fitted to the uv of a floor by least squares over the corners of its
// triangles.
struct PlaneUv {
  Vec3 point = Vec3::Zero();  // mean of the corners [m]
  Vec2 at_point = Vec2::Zero();
  Eigen::Matrix<double, 2, 3> gradient = Eigen::Matrix<double, 2, 3>::Zero();  // [1]

  Vec2 at(const Vec3& place) const { return at_point + gradient * (place - point); }
};
// Returns zeros for floors without uv.
PlaneUv floor_uv(const FrameTopology& topology, const Points& x, Index body);

struct Rectangle {
  int left, bottom, width, height;  // pixels, from the lower left corner
};

// Bounding rectangle of points [pixels], with a margin. It is the whole picture if a point is not
// beyond the near clipping plane.
class Reach {
 public:
  Reach(const View& view, int width, int height) : view_(view), width_(width), height_(height) {}
  void include(const Vec3& point);
  Rectangle rectangle() const;

 private:
  const View& view_;
  int width_, height_;
  Vec2 low_ = Vec2::Constant(1e9), high_ = Vec2::Constant(-1e9);
};

}  // namespace loomstone
