#include "core/magnetics/forces/charge_error.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "core/magnetics/forces/cells.h"
#include "core/magnetics/forces/panel_wrench.h"
#include "core/magnetics/forces/sphere_series.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

// Returns the distance between the bounding boxes of two bodies, divided by the shortest edge of
// the induced body's box and clamped to the range in which calibrated() was fitted. Returns 1 if a
// body has no box (currents, dipoles).
double relative_gap(const MagneticBody& induced, const MagneticBody& by) {
  const auto box = induced.source->box(), other = by.source->box();
  if (!box || !other) return 1.0;
  const double gap = box_distance(box->first, box->second, other->first, other->second,
                                  relative_pose(by.pose, induced.pose));
  return std::clamp(gap / (box->second - box->first).minCoeff(), 0.1, 2.0);
}

// Converts `difference`, the force on the estimated errors of the charge, into an estimated error
// of `force`, the force on the charge. Torque / radius replaces a force if it is larger. `gap` is
// the result of relative_gap(). The charge errors of panels are estimated by comparing two
// Richardson extrapolations. These estimates exaggerate large errors and miss part of the error
// near a magnet. The formula was therefore fitted to true errors. In about nine of ten cases, its
// result is between half and ten times the true error (docs/experiments/magnetics.md).
double calibrated(double difference, double force, double gap) {
  if (!(force > 0.0)) return difference;
  return 0.044 * force * std::pow(difference / force, 0.8) * std::pow(gap, -0.6);
}

// Returns the factor by which the estimated error of the force on `on` is multiplied if both bodies
// are induced, because both charges then have errors. Opposite the edges of `by`, the charge of
// `on` varies at the scale of the gap, but the panels of `on` are not refined there. If the edges
// of the bounding boxes of the bodies are parallel and the gap is less than 2.5 times the width
// (square root of the area) of the largest panel on the finest grid of `on`, the errors add up
// along whole edges, and the factor is larger. The factors were fitted to true errors, like the
// formula of calibrated().
double mutual_factor(const MagneticBody& on, const MagneticBody& by) {
  constexpr double usual = 2.5, along_edges = 5.0, wide = 2.5, parallel = 1e-3;
  const auto box = on.source->box(), other = by.source->box();
  const ChargedPanels* charged = on.source->charged_panels();
  if (!box || !other || !charged) return usual;
  const RigidPose pose = relative_pose(by.pose, on.pose);
  const Mat3 turns = rotation_matrix(pose.orientation).cwiseAbs();
  if (turns.colwise().maxCoeff().minCoeff() < 1.0 - parallel) return usual;
  const PanelGrid& finest = charged->set().grids.back();
  double area = 0.0;
  for (Index i = finest.begin; i < finest.end; ++i)
    area = std::max(area, charged->set().panels[i].area);
  const double gap = box_distance(box->first, box->second, other->first, other->second, pose);
  return gap < wide * std::sqrt(area) ? along_edges : usual;
}

// Returns two wrenches about `centre` that `by` exerts. The first acts on the charge of `induced`,
// the second on the estimated errors of this charge.
std::vector<Wrench> wrenches(const MagneticBody& induced, const MagneticBody& by,
                             const Vec3& centre) {
  if (const auto mine = mean_charges(induced), others = mean_charges(by); mine && others) {
    const ChargedPanels& panels = *induced.source->charged_panels();
    const Vec3 arm = induced.pose.position - centre;
    std::vector<Wrench> result =
        panel_wrenches(mine->set, induced.pose, {mine->charges, panels.panel_errors()}, *others);
    for (Wrench& w : result) w.torque += arm.cross(w.force);
    return result;
  }
  std::vector<Wrench> result(2);
  const std::vector<PanelSample> charges = induced.source->charges();
  const Vector errors = induced.source->charge_errors();
  Points local(charges.size(), 3), x(charges.size(), 3);
  for (std::size_t i = 0; i < charges.size(); ++i) local.row(i) = charges[i].position.transpose();
  place_points(induced.pose, local, x);
  const SourcePtr means = by.source->panel_means();  // their field is cheaper to evaluate
  const Points field = magnetic_field(Team{}, {{means ? means : by.source, by.pose}}, x, "B");
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const double charge[2] = {charges[static_cast<std::size_t>(i)].charge,
                              i < errors.size() ? errors[i] : 0.0};
    const Vec3 b = field.row(i).transpose(), moment = (x.row(i).transpose() - centre).cross(b);
    for (int k = 0; k < 2; ++k) {
      result[k].force += charge[k] * b;
      result[k].torque += charge[k] * moment;
    }
  }
  return result;
}

// Returns the estimated error of `force`, the force (or torque / radius) between a sphere with
// induced charge and another body, due to the truncation of the sphere's series [N]. The result is
// 0 for two such spheres, because their charges are smoother than that of a sphere beside a magnet.
//
// The decay of the coefficients (SeriesEnd::decay) is used only if the series has converged or the
// user has chosen a low degree. Otherwise, most of the force can be missing from the series. The
// result is then at least the force between a plane of infinite permeability and a dipole with the
// moment of the other body.
double error_of_series(const MagneticBody& sphere, const MagneticBody& by, double force) {
  if (by.source->series_end().degree > 0) return 0.0;
  constexpr double converged = 6.0;
  // Lower degrees count as chosen by the user. Degrees that are chosen automatically are so low
  // only at large distances.
  constexpr int chosen = 10;
  const SeriesEnd end = sphere.source->series_end();
  const double radius = sphere.source->radius(),
               distance = distance_to_source(by, sphere.pose.position),
               decay = sphere_decay(radius, distance);
  if (end.degree < chosen || decay * end.degree > converged)
    return force * truncated_share({end.degree, std::max(end.decay, decay)});
  const double gap = distance - radius + (by.source->dipoles() ? 0.0 : by.source->radius());
  const double of_plane =
      3.0 * mu0 * by.source->moment().squaredNorm() / (32.0 * pi * std::pow(gap, 4));
  return std::max(force * truncated_share({end.degree, decay}), of_plane);
}

// Returns the estimated error of the force on an induced body, or of the torque about `centre`
// divided by `radius` if that is larger [N]. Returns NaN if the errors of the charge are unknown.
double error_on_induced(const MagneticBody& induced, const MagneticBody& by, const Vec3& centre,
                        double radius) {
  if (induced.source->charge_errors().size() == 0) return std::numeric_limits<double>::quiet_NaN();
  const std::vector<Wrench> on = wrenches(induced, by, centre);
  const auto larger = [&](int k) {
    return std::max(on[k].force.norm(), on[k].torque.norm() / radius);
  };
  if (induced.source->spherical())
    return std::max(larger(1), error_of_series(induced, by, larger(0)));
  const double estimate = calibrated(larger(1), larger(0), relative_gap(induced, by));
  return by.source->induced() ? mutual_factor(induced, by) * estimate : estimate;
}

}  // namespace

double charge_error(const MagneticBody& on, const MagneticBody& by) {
  const Vec3& centre = on.pose.position;
  // A single dipole has no size, so the other body's size takes its place.
  const double radius = on.source->radius() > 0.0 ? on.source->radius() : by.source->radius();
  double error = 0.0;
  if (on.source->induced()) error += error_on_induced(on, by, centre, radius);
  if (by.source->induced()) error += error_on_induced(by, on, centre, radius);
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
