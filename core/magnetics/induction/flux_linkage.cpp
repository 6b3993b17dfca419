#include "core/magnetics/induction/flux_linkage.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/simd.h"
#include "core/magnetics/sources/axisymmetric.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

// Ratio of length to radius of the solenoid that represents a loop. Except near the wire, the
// relative error of the potential is at most of the order of the square of this ratio.
constexpr double loop_length = 1e-3;

// The magnet with the same outer field as a winding. It is polarised along z by mu0 times the
// current per length.
struct Bore {
  double radius, half_length, polarization;
};

Bore bore_of(const Source& coil) {
  const std::optional<CircularWinding> w = coil.winding();
  if (!w) throw InvalidInput("only loops and solenoids have a flux linkage, got another source");
  if (w->length > 0.0) return {w->radius, 0.5 * w->length, mu0 * w->current};
  const double length = loop_length * w->radius;
  return {w->radius, 0.5 * length, mu0 * w->current / length};
}

// Records whether those parts of the edge from a to b that lie between the heights of the winding's
// ends are in the bore or outside it. Only these points of the edge are tested: its ends, if they
// lie between these heights, and the points at the heights of the winding's middle and ends.
void note_edge(const Bore& bore, const Vec3& a, const Vec3& b, BesideWinding& found) {
  const auto note = [&](const Vec3& x) {
    (x.head<2>().norm() < bore.radius ? found.in_bore : found.outside) = true;
  };
  if (std::abs(a[2]) <= bore.half_length) note(a);
  if (std::abs(b[2]) <= bore.half_length) note(b);
  for (const double z : {-bore.half_length, 0.0, bore.half_length})
    if ((a[2] < z && b[2] > z) || (a[2] > z && b[2] < z))
      note(a + (z - a[2]) / (b[2] - a[2]) * (b - a));
}

// Returns mu0 times the scalar potential of the winding [T m]. The points are given in the axes of
// the winding. `threaded` selects the branch of the potential that is continuous in the bore.
Vector winding_potential(const Bore& bore, bool threaded, const Points& points) {
  const Cylinder magnet(bore.radius, 2.0 * bore.half_length, Vec3(0, 0, bore.polarization));
  Vector potential(points.rows());
  alignas(64) double x[3 * points_per_block], values[points_per_block];
  for (Index begin = 0; begin < points.rows(); begin += points_per_block) {
    const Index count =
        std::min<Index>(points_per_block, static_cast<Index>(points.rows()) - begin);
    const Index n = (count + n_lanes - 1) / n_lanes * n_lanes;
    for (Index i = 0; i < n; ++i)
      for (int c = 0; c < 3; ++c) x[c * n + i] = points(begin + std::min(i, count - 1), c);
    magnet.potential_block(x, n, values);
    for (Index i = 0; i < count; ++i) {
      const double along = std::clamp(points(begin + i, 2), -bore.half_length, bore.half_length);
      potential[begin + i] = values[i] - (threaded ? bore.polarization * along : 0.0);
    }
  }
  return potential;
}

}  // namespace

BesideWinding beside_winding(const MagneticBody& coil, const MagneticBody& body) {
  const Bore bore = bore_of(*coil.source);
  const RigidPose pose = relative_pose(body.pose, coil.pose);
  const Mat3 rotation = rotation_matrix(pose.orientation);
  BesideWinding found;
  bool polygons = false;
  for (const Panel& panel : body.source->surface()) {
    if (panel.shape != Panel::Shape::triangle && panel.shape != Panel::Shape::parallelogram)
      continue;
    polygons = true;
    Vec3 corners[4] = {panel.a, panel.a + panel.b, panel.a + panel.c, panel.a + panel.c};
    if (panel.shape == Panel::Shape::parallelogram) corners[2] += panel.b;
    for (Vec3& corner : corners) corner = pose.position + rotation * corner;
    for (int k = 0; k < 4; ++k) note_edge(bore, corners[k], corners[(k + 1) % 4], found);
  }
  if (polygons) return found;
  // Height within the winding that is nearest to the centre of the body.
  const double z = std::clamp(pose.position[2], -bore.half_length, bore.half_length);
  if (std::abs(pose.position[2] - z) < body.source->radius())
    (pose.position.head<2>().norm() < bore.radius ? found.in_bore : found.outside) = true;
  return found;
}

double linked_flux(const MagneticBody& coil, const MagneticBody& magnetised) {
  const RigidPose pose = relative_pose(magnetised.pose, coil.pose);
  const Mat3 rotation = rotation_matrix(pose.orientation);
  if (const DipoleSet* dipoles = magnetised.source->dipoles()) {
    const Points at =
        (dipoles->positions() * rotation.transpose()).rowwise() + pose.position.transpose();
    const Points field = magnetic_field(Team{1}, {{coil.source, {}}}, at, "B");
    return field.cwiseProduct(dipoles->moments() * rotation.transpose()).sum();
  }
  const std::vector<PanelSample> charges = magnetised.source->charges();
  Points at(static_cast<Eigen::Index>(charges.size()), 3);
  for (std::size_t i = 0; i < charges.size(); ++i)
    at.row(static_cast<Eigen::Index>(i)) =
        (pose.position + rotation * charges[i].position).transpose();
  const BesideWinding beside = beside_winding(coil, magnetised);
  if (beside.in_bore && beside.outside)
    throw Unsupported(
        "a body that magnetises must lie in the bore of a coil or outside it, got one "
        "that reaches around the winding or overlaps it; move it or split it");
  const Vector potential = winding_potential(bore_of(*coil.source), beside.in_bore, at);
  double flux = 0.0;
  for (std::size_t i = 0; i < charges.size(); ++i)
    flux -= charges[i].charge * potential[static_cast<Eigen::Index>(i)];
  return flux;
}

}  // namespace loomstone
