#include "core/magnetics/coil_flux.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/simd.h"
#include "core/magnetics/axisymmetric.h"
#include "core/magnetics/constants.h"

namespace loomstone {

namespace {

// A loop is a solenoid of this length over radius: its potential differs by the square of that over 24.
constexpr double loop_length = 1e-3;

// The winding as a magnet of the same outer field: polarised along z by mu0 times the current on its side per length.
struct Bore {
  double radius, half_length, polarization;
};

Bore bore_of(const Source& coil) {
  if (const auto* s = dynamic_cast<const Solenoid*>(&coil))
    return {s->coil_radius(), 0.5 * s->length(), mu0 * s->sheet_current()};
  const auto* loop = dynamic_cast<const Loop*>(&coil);
  if (!loop) throw InvalidInput("a flux is linked by loops and solenoids, got another source");
  const double length = loop_length * loop->radius();
  return {loop->radius(), 0.5 * length, mu0 * loop->current() / length};
}

// Whether the body lies in the bore, told by its points beside the winding, else by where the line between its ends passes it.
bool in_bore(const Bore& bore, const Points& points) {
  int inside = 0, outside = 0;
  Index low = 0, high = 0;
  for (Index i = 0; i < points.rows(); ++i) {
    if (points(i, 2) < points(low, 2)) low = i;
    if (points(i, 2) > points(high, 2)) high = i;
    if (std::abs(points(i, 2)) > bore.half_length) continue;
    ++(points.row(i).head<2>().norm() < bore.radius ? inside : outside);
  }
  if (inside > 0 && outside > 0)
    throw Unsupported("a circuit beside bodies that magnetise must have them in its bore or beside it, got one that reaches round "
                      "the winding; split the body");
  if (inside + outside > 0) return inside > 0;
  const double from = points(low, 2), to = points(high, 2);
  if (from > 0.0 || to < 0.0) return false;  // beyond an end, where both branches differ by a constant
  const Vec3 at = points.row(low) + (to > from ? -from / (to - from) : 0.0) * (points.row(high) - points.row(low));
  return at.head<2>().norm() < bore.radius;
}

// mu0 times the scalar potential of the winding with one ampere at points in its axes [T m].
Vector winding_potential(const Bore& bore, const Points& points) {
  const Cylinder magnet(bore.radius, 2.0 * bore.half_length, Vec3(0, 0, bore.polarization));
  const bool threaded = in_bore(bore, points);
  Vector potential(points.rows());
  alignas(64) double x[3 * points_per_block], values[points_per_block];
  for (Index begin = 0; begin < points.rows(); begin += points_per_block) {
    const Index count = std::min<Index>(points_per_block, static_cast<Index>(points.rows()) - begin);
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

double linked_flux(const MagneticBody& coil, const MagneticBody& magnetised) {
  const RigidPose pose = relative_pose(magnetised.pose, coil.pose);
  const Mat3 rotation = rotation_matrix(pose.orientation);
  if (const DipoleSet* dipoles = magnetised.source->dipoles()) {
    const Points at = (dipoles->positions() * rotation.transpose()).rowwise() + pose.position.transpose();
    const Points field = magnetic_field(Team{1}, {{coil.source, {}}}, at, "B");
    return field.cwiseProduct(dipoles->moments() * rotation.transpose()).sum();
  }
  const std::vector<PanelSample> charges = magnetised.source->charges();
  Points at(static_cast<Eigen::Index>(charges.size()), 3);
  for (std::size_t i = 0; i < charges.size(); ++i)
    at.row(static_cast<Eigen::Index>(i)) = (pose.position + rotation * charges[i].position).transpose();
  const Vector potential = winding_potential(bore_of(*coil.source), at);
  double flux = 0.0;
  for (std::size_t i = 0; i < charges.size(); ++i) flux -= charges[i].charge * potential[static_cast<Eigen::Index>(i)];
  return flux;
}

}  // namespace loomstone
