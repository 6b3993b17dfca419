#include "core/magnetics/forces/relative_motion.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

namespace {

// The dipoles of all magnets, as rows of a table with the columns `Column`: position [m], velocity
// [m/s], and size of the part that the dipole represents [m].
struct Dipoles {
  Eigen::Array<double, Eigen::Dynamic, 7> table;
  std::vector<Index> starts;  // first row of each magnet, followed by the number of rows
};
enum Column { x, y, z, vx, vy, vz, size };

Dipoles dipoles_of(const MovingMagnets& moving) {
  Dipoles dipoles;
  dipoles.starts.push_back(0);
  for (const CoarseMagnet& magnet : moving.magnets)
    dipoles.starts.push_back(dipoles.starts.back() + magnet.positions->rows());
  dipoles.table.resize(dipoles.starts.back(), 7);
  for (std::size_t i = 0; i < moving.magnets.size(); ++i) {
    const CarrierMotion& motion = moving.motions[moving.carriers[i]];
    Points world(moving.magnets[i].positions->rows(), 3);
    place_points(moving.poses[i], *moving.magnets[i].positions, world);
    for (Eigen::Index p = 0; p < world.rows(); ++p) {
      const Vec3 at = world.row(p).transpose();
      const Vec3 v = motion.velocity + motion.spin.cross(at - motion.centre);
      dipoles.table.row(dipoles.starts[i] + p) << at[0], at[1], at[2], v[0], v[1], v[2],
          moving.magnets[i].size;
    }
  }
  return dipoles;
}

double spin_of(const MovingMagnets& moving, Index i) {
  return moving.magnets[i].soft_sphere ? 0.0 : moving.motions[moving.carriers[i]].spin.norm();
}

// Returns an upper bound of the result of relative_motion_rate() [1/s]: twice the largest velocity
// of a dipole, divided by the size of the smallest part, plus the largest angular velocity.
double upper_bound(const MovingMagnets& moving, const Dipoles& dipoles) {
  const auto& t = dipoles.table;
  const double fastest = std::sqrt(t.middleCols<3>(vx).square().rowwise().sum().maxCoeff());
  double spin = 0.0;
  for (std::size_t i = 0; i < moving.magnets.size(); ++i)
    spin = std::max(spin, spin_of(moving, static_cast<Index>(i)));
  const double closest = t.col(size).minCoeff();
  return spin + (fastest == 0.0 ? 0.0 : 2.0 * fastest / closest);
}

// Returns the rate of a pair of magnets [1/s].
double pair_rate(const MovingMagnets& moving, const Dipoles& dipoles, Index i, Index k) {
  const auto& t = dipoles.table;
  double square = 0.0;  // largest squared ratio of relative velocity to distance [1/s^2]
  for (Index p = dipoles.starts[i]; p < dipoles.starts[i + 1]; ++p) {
    for (Index q = dipoles.starts[k]; q < dipoles.starts[k + 1]; ++q) {
      const Vec3 apart(t(p, x) - t(q, x), t(p, y) - t(q, y), t(p, z) - t(q, z));
      const Vec3 velocity(t(p, vx) - t(q, vx), t(p, vy) - t(q, vy), t(p, vz) - t(q, vz));
      const double closest = 0.5 * (t(p, size) + t(q, size));
      const double distance2 = std::max(apart.squaredNorm(), closest * closest);
      if (distance2 > 0.0) square = std::max(square, velocity.squaredNorm() / distance2);
    }
  }
  return std::sqrt(square) + std::max(spin_of(moving, i), spin_of(moving, k));
}

}  // namespace

double relative_motion_rate(const Team& team, const MovingMagnets& moving, double negligible) {
  const auto n = static_cast<Index>(moving.magnets.size());
  const Dipoles dipoles = dipoles_of(moving);
  if (dipoles.table.rows() == 0) return 0.0;
  const double bound = upper_bound(moving, dipoles);
  if (bound <= negligible) return bound;
  std::vector<double> largest(n, 0.0);
  parallel_for(
      team, n,
      [&](Index i) {
        for (Index k = 0; k < i; ++k)
          if (moving.carriers[i] != moving.carriers[k])
            largest[i] = std::max(largest[i], pair_rate(moving, dipoles, i, k));
      },
      8);
  return *std::max_element(largest.begin(), largest.end());
}

}  // namespace loomstone
