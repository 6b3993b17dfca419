#include "core/collision/model/rigid_motion.h"

#include <algorithm>

namespace loomstone {

namespace {

Mat3 frame(const Vec3& a, const Vec3& b, const Vec3& c) {
  Mat3 axes;
  axes.col(0) = (b - a).normalized();
  axes.col(2) = (b - a).cross(c - a).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

}  // namespace

RigidMotion rigid_motion(const CollisionModel& model, Index s, const Points& x0, const Points& x1) {
  const CollisionSurface& surface = model.surfaces[s];
  return rigid_motion(x0.middleRows(surface.first_vertex, surface.n_vertices),
                      x1.middleRows(surface.first_vertex, surface.n_vertices));
}

RigidMotion rigid_motion(const Eigen::Ref<const Points>& start,
                         const Eigen::Ref<const Points>& end) {
  RigidMotion motion;
  const Index n = static_cast<Index>(start.rows());
  if (n < 3) return motion;
  motion.from = start.row(0).transpose();
  motion.to = end.row(0).transpose();
  // A pure translation is tested first, so that its rotation is exactly the identity.
  const double size = (start.rowwise() - start.row(0)).rowwise().norm().maxCoeff();
  const double tolerance = 1e-10 * std::max(size, motion.from.norm());
  const auto residual = [&] {
    double largest = 0.0;
    for (Index i = 0; i < n; ++i)
      largest = std::max(largest, (motion.displacement(start.row(i).transpose()) -
                                   (end.row(i) - start.row(i)).transpose())
                                      .norm());
    return largest;
  };
  if (residual() <= tolerance) {
    motion.rigid = true;
    return motion;
  }
  // Three vertices far from each other determine the rotation.
  Index second = 0, third = 0;
  (start.rowwise() - start.row(0)).rowwise().squaredNorm().maxCoeff(&second);
  const Vec3 axis = (start.row(second) - start.row(0)).transpose();
  double best = 0.0;
  for (Index i = 0; i < n; ++i) {
    const double area = axis.cross(Vec3((start.row(i) - start.row(0)).transpose())).norm();
    if (area > best) {
      best = area;
      third = i;
    }
  }
  if (!(best > 0.0)) return motion;
  const auto frame_of = [&](const auto& x) {
    return frame(x.row(0).transpose(), x.row(second).transpose(), x.row(third).transpose());
  };
  motion.rotation = frame_of(end) * frame_of(start).transpose();
  motion.rigid = residual() <= tolerance;
  if (!motion.rigid) motion.rotation = Mat3::Identity();
  return motion;
}

}  // namespace loomstone
