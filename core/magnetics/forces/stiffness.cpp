#include "core/magnetics/forces/stiffness.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

namespace {

constexpr int most_parts = 64;
constexpr double longest_part =
    1.5;  // largest ratio of a part's longest edge to the cube root of its volume

// Returns the centres of the parts of a box that is divided into count[k] parts along axis k. The
// vector `part` contains the edge lengths of a part [m].
Points part_middles(const Vec3& low, const Vec3& part, const int* count) {
  Points positions(count[0] * count[1] * count[2], 3);
  Index row = 0;
  for (int i = 0; i < count[0]; ++i)
    for (int j = 0; j < count[1]; ++j)
      for (int k = 0; k < count[2]; ++k)
        positions.row(row++) =
            (low + part.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5))).transpose();
  return positions;
}

// Divides a box into equal parts. Returns the centres of the parts, and as their size the cube root
// of the volume of a part. longest_part bounds the aspect ratio of the parts, unless this would
// need more than most_parts of them.
CoarseMagnet divided(const Vec3& low, const Vec3& high) {
  const Vec3 edges = high - low;
  int count[3] = {1, 1, 1};
  for (;;) {
    const Vec3 part(edges[0] / count[0], edges[1] / count[1], edges[2] / count[2]);
    int axis;
    const double longest = part.maxCoeff(&axis);
    if (longest <= longest_part * std::cbrt(part.prod()) ||
        count[0] * count[1] * count[2] * 2 > most_parts) {
      CoarseMagnet coarse;
      coarse.positions = std::make_shared<const Points>(part_middles(low, part, count));
      coarse.size = std::cbrt(part.prod());
      return coarse;
    }
    count[axis] *= 2;
  }
}

}  // namespace

CoarseMagnet coarse_magnet(const Source& source) {
  CoarseMagnet coarse;
  if (const auto box = source.box()) {
    coarse = divided(box->first, box->second);
  } else if (const auto winding = source.winding()) {
    const double radius = winding->radius;
    const Vec3 reach(radius, radius, 0.5 * std::max(winding->length, radius));
    coarse = divided(-reach, reach);
  } else if (const DipoleSet* set = source.dipoles(); set && set->positions().rows() > 0) {
    coarse.positions = std::make_shared<const Points>(set->positions());
    coarse.moment = set->moments().rowwise().norm().maxCoeff();
    return coarse;
  } else {
    coarse.positions = std::make_shared<const Points>(Points::Zero(1, 3));
    coarse.size = source.radius();
  }
  coarse.moment = source.moment().norm() / static_cast<double>(coarse.positions->rows());
  return coarse;
}

namespace {

bool fixed(const Carrier& carrier) {
  return carrier.inverse_mass == 0.0 && carrier.inverse_inertia == 0.0;
}

// Returns an upper bound of the mobility of a point of a carrier: the acceleration of the point per
// force at the point [1/kg].
double yielding(const Carrier& carrier, const Vec3& point) {
  return carrier.inverse_mass + (point - carrier.centre).squaredNorm() * carrier.inverse_inertia;
}

// Returns the largest restoring stiffness of two dipoles with constant moments at the distance r,
// times r^5 / (3 mu0/4pi). This stiffness is the largest eigenvalue of the Hessian of their energy;
// the Hessian is traceless. n is the unit vector from one dipole to the other.
double driving_back(const Vec3& m, const Vec3& other, const Vec3& n) {
  const double a = m.dot(n), b = other.dot(n), product = m.dot(other);
  const Mat3 crossed = m * other.transpose(), turned = (a * other + b * m) * n.transpose();
  const Mat3 h = (5.0 * a * b - product) * Mat3::Identity() +
                 5.0 * (product - 7.0 * a * b) * n * n.transpose() - crossed - crossed.transpose() +
                 5.0 * (turned + turned.transpose());
  const double size = std::sqrt(h.squaredNorm() / 6.0);
  if (size == 0.0) return 0.0;
  const double shape = std::clamp(h.determinant() / (2.0 * size * size * size), -1.0, 1.0);
  // cos(acos(shape) / 3) is a smooth function of s = cos(acos(shape) / 2). The polynomial in s
  // below exceeds this function by at most 2.2e-5.
  const double s = std::sqrt(0.5 * (1.0 + shape));
  return 2.0 * size *
         (0.5000217 + s * (0.5768125 + s * (-0.1064940 + s * (0.0383529 - 0.0086883 * s))));
}

// Number of values per soft sphere in the table of far_kernel(): position (3), radius, norm of the
// moment, and mobility (see yielding()).
constexpr int sphere_rows = 6;
// If the distance between the centres of two spheres is at least this multiple of the sum of their
// radii, the bound 24 mu0/4pi m m' / r^5 for any two dipoles m and m' replaces the largest
// restoring stiffness of the spheres.
constexpr double neighbours = 1.6;

// Returns an upper bound of the amount by which all spheres far from sphere i (see `neighbours`)
// raise the squared angular frequency of its carrier, divided by the moment of i and by mu0/4pi.
// `near` receives the indices of the spheres that are not far, among them i. Indices from the
// number of spheres on are padding, which the caller must skip.
template <class Lanes>
LOOMSTONE_INLINE double far_kernel(const double* table, Index padded, Index i, Index* near,
                                   Index* n_near) {
  const double x = table[i], y = table[padded + i], z = table[2 * padded + i],
               radius = table[3 * padded + i], own = table[5 * padded + i];
  Lanes sum{};
  Index count = 0;
  for (Index k = 0; k < padded; k += n_lanes) {
    const double* t = table + k;
    const Lanes3<Lanes> r{lanes_load<Lanes>(t) - x, lanes_load<Lanes>(t + padded) - y,
                          lanes_load<Lanes>(t + 2 * padded) - z};
    const Lanes square = dot(r, r),
                reach = neighbours * (lanes_load<Lanes>(t + 3 * padded) + radius);
    const MaskOf<Lanes> far = square >= reach * reach;
    const Lanes inverse = 1.0 / lanes_select(far, square, lanes_all<Lanes>(1.0));
    const Lanes bound = lanes_load<Lanes>(t + 4 * padded) * (inverse * inverse) *
                        lanes_sqrt(inverse) * (lanes_load<Lanes>(t + 5 * padded) + own);
    sum += lanes_select(far, bound, Lanes{});
    for (int lane = 0; lane < n_lanes; ++lane) {
      near[count] = k + lane;
      count += far[lane] ? 0 : 1;
    }
  }
  *n_near = count;
  return 24.0 * (((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7])));
}

}  // namespace

namespace {

struct PlacedMagnet {
  const CoarseMagnet& magnet;
  const Points& world;  // world positions of its dipoles [m]
  const Carrier& carrier;
};

// Returns an upper bound of the amount by which the forces and torques between two magnets raise
// the squared angular frequency of each of their carriers [1/s^2].
double pair_frequency2(const PlacedMagnet& a, const PlacedMagnet& b) {
  const double turning = (a.magnet.soft_sphere ? 0.0 : a.carrier.inverse_inertia) +
                         (b.magnet.soft_sphere ? 0.0 : b.carrier.inverse_inertia);
  const double closest = 0.5 * (a.magnet.size + b.magnet.size);
  const double strength = mu0 / (4.0 * pi) * a.magnet.moment * b.magnet.moment;
  double pair = 0.0;
  for (Eigen::Index p = 0; p < a.world.rows(); ++p) {
    for (Eigen::Index q = 0; q < b.world.rows(); ++q) {
      const double r = std::max((a.world.row(p) - b.world.row(q)).norm(), closest);
      if (r == 0.0) continue;
      const double cube = strength / (r * r * r), force = 24.0 * cube / (r * r),
                   torque = 2.0 * cube;
      pair += force * (yielding(a.carrier, a.world.row(p).transpose()) +
                       yielding(b.carrier, b.world.row(q).transpose())) +
              torque * turning;
    }
  }
  return pair;
}

}  // namespace

std::vector<double> frequencies2(const std::vector<CoarseMagnet>& magnets,
                                 const std::vector<RigidPose>& poses,
                                 const std::vector<Index>& carrier,
                                 const std::vector<Carrier>& carriers, double field) {
  std::vector<double> result(carriers.size(), 0.0);
  // `others` are all magnets except soft spheres, whose mutual forces are not counted here.
  std::vector<std::size_t> all(magnets.size()), others;
  std::iota(all.begin(), all.end(), 0);
  std::copy_if(all.begin(), all.end(), std::back_inserter(others),
               [&](std::size_t k) { return !magnets[k].soft_sphere; });
  // This function omits the forces of fixed magnets on soft spheres. If all `others` are fixed, it
  // therefore skips the soft spheres.
  if (std::all_of(others.begin(), others.end(),
                  [&](std::size_t k) { return fixed(carriers[carrier[k]]); }))
    all = others;
  std::vector<Points> world(magnets.size());
  for (const std::size_t i : all) {
    world[i].resize(magnets[i].positions->rows(), 3);
    place_points(poses[i], *magnets[i].positions, world[i]);
    if (!magnets[i].soft_sphere)
      result[carrier[i]] += magnets[i].moment * static_cast<double>(world[i].rows()) * field *
                            carriers[carrier[i]].inverse_inertia;
  }
  for (const std::size_t i : all) {
    for (const std::size_t k : magnets[i].soft_sphere ? others : all) {
      if (k <= i) continue;
      const Carrier &a = carriers[carrier[i]], &b = carriers[carrier[k]];
      if (carrier[i] == carrier[k] || (fixed(a) && fixed(b))) continue;
      if ((magnets[i].soft_sphere && fixed(b)) || (magnets[k].soft_sphere && fixed(a))) continue;
      const double pair = pair_frequency2({magnets[i], world[i], a}, {magnets[k], world[k], b});
      result[carrier[i]] += pair;
      result[carrier[k]] += pair;
    }
  }
  return result;
}

void add_sphere_frequencies2(const Team& team, const std::vector<SoftSphere>& spheres,
                             const std::vector<Carrier>& carriers,
                             std::vector<double>& frequencies2) {
  const Index n = static_cast<Index>(spheres.size()),
              padded = (n + n_lanes - 1) / n_lanes * n_lanes;
  std::vector<double> table(sphere_rows * static_cast<std::size_t>(padded)), each(n);
  for (Index i = 0; i < padded; ++i) {
    const SoftSphere& s = spheres[std::min(i, n - 1)];
    const double row[] = {s.position[0],
                          s.position[1],
                          s.position[2],
                          s.radius,
                          i < n ? s.moment.norm() : 0.0,
                          yielding(carriers[s.carrier], s.position)};
    for (int c = 0; c < sphere_rows; ++c) table[c * padded + i] = row[c];
  }
  parallel_for(
      team, n,
      [&](Index i) {
        std::vector<Index> near(padded);
        Index n_near = 0;
        const SoftSphere& on = spheres[i];
        const double own = table[5 * padded + i];
        double sum = on.moment.norm() *
                     LOOMSTONE_WIDEST(far_kernel)(table.data(), padded, i, near.data(), &n_near);
        for (Index k = 0; k < n_near; ++k) {
          const SoftSphere& by = spheres[near[k]];
          if (near[k] >= n || by.carrier == on.carrier) continue;
          const Vec3 arm = on.position - by.position;
          const double touching = on.radius + by.radius, distance = arm.norm();
          if (distance == 0.0) continue;
          const double r = std::max(distance, 0.9 * touching);
          sum += 3.0 * driving_back(on.moment, by.moment, arm / distance) / (r * r * r * r * r) *
                 (own + table[5 * padded + near[k]]);
        }
        each[i] = mu0 / (4.0 * pi) * sum;
      },
      32);
  for (Index i = 0; i < n; ++i) frequencies2[spheres[i].carrier] += each[i];
}

void add_sphere_frequencies2(const Team& team, const std::vector<SoftSphere>& spheres,
                             const FixedMagnet& by, const std::vector<Carrier>& carriers,
                             std::vector<double>& frequencies2) {
  const Index n = static_cast<Index>(spheres.size());
  const bool few = by.magnet.positions->rows() <= most_parts;
  Points parts(by.magnet.positions->rows(), 3);
  place_points(by.pose, *by.magnet.positions, parts);
  std::vector<double> each(n);
  parallel_for(
      team, n,
      [&](Index i) {
        const SoftSphere& on = spheres[i];
        const double closest = on.radius + 0.5 * by.magnet.size, moment = on.moment.norm();
        double coarse = few ? 0.0 : std::numeric_limits<double>::infinity();
        for (Eigen::Index p = 0; few && p < parts.rows(); ++p) {
          const double r = std::max((parts.row(p).transpose() - on.position).norm(), closest),
                       r2 = r * r;
          coarse += 1.0 / (r2 * r2 * r);
        }
        coarse *= 24.0 * mu0 / (4.0 * pi) * by.magnet.moment;
        const double stiffness =
            moment * std::min(coarse, 4.0 * by.gradient.row(i).norm() / on.radius);
        each[i] = stiffness * yielding(carriers[on.carrier], on.position);
      },
      32);
  for (Index i = 0; i < n; ++i) frequencies2[spheres[i].carrier] += each[i];
}

}  // namespace loomstone
