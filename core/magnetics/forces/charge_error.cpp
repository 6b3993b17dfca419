#include "core/magnetics/forces/charge_error.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <numeric>

namespace loomstone {

namespace {

// Returns the force on the errors of an induced body's charge, and the torque about `centre`
// divided by `radius`, whichever is larger [N].
double force_on_errors(const MagneticBody& induced, const MagneticBody& by, const Vec3& centre,
                       double radius) {
  const std::vector<PanelSample> charges = induced.source->charges();
  const Vector errors = induced.source->charge_errors();
  if (errors.size() == 0) return std::numeric_limits<double>::quiet_NaN();
  Points local(errors.size(), 3), x(errors.size(), 3);
  for (Eigen::Index i = 0; i < errors.size(); ++i)
    local.row(i) = charges[static_cast<std::size_t>(i)].position.transpose();
  place_points(induced.pose, local, x);
  const SourcePtr means = by.source->panel_means();  // its field is cheaper
  const Points field = magnetic_field(Team{}, {{means ? means : by.source, by.pose}}, x, "B");
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    const Vec3 part = errors[i] * field.row(i).transpose();
    force += part;
    torque += (x.row(i).transpose() - centre).cross(part);
  }
  return std::max(force.norm(), torque.norm() / radius);
}

}  // namespace

double charge_error(const MagneticBody& on, const MagneticBody& by) {
  const Vec3& centre = on.pose.position;
  const double radius = on.source->radius();
  double error = 0.0;
  if (on.source->induced()) error += force_on_errors(on, by, centre, radius);
  if (by.source->induced()) error += force_on_errors(by, on, centre, radius);
  return error;
}

Vector charge_errors(const Team& team, const std::vector<MagneticBody>& bodies) {
  Vector errors = Vector::Zero(static_cast<Eigen::Index>(bodies.size()));
  std::vector<Index> induced, all(bodies.size());
  std::iota(all.begin(), all.end(), 0);
  std::copy_if(all.begin(), all.end(), std::back_inserter(induced),
               [&](Index i) { return bodies[i].source->induced(); });
  parallel_tasks(team, static_cast<Index>(bodies.size()), [&](Index i) {
    for (const Index k : bodies[i].source->induced() ? all : induced)
      if (k != i) errors[i] += charge_error(bodies[i], bodies[k]);
  });
  return errors;
}

}  // namespace loomstone
