#include "core/magnetics/stiffness.h"

#include <algorithm>
#include <cmath>

#include "core/magnetics/constants.h"

namespace loomstone {

namespace {

constexpr int most_parts = 64;
constexpr double longest_part = 1.5;  // edge over cubic root of the volume

// Parts a box into equal boxes that are nearly cubes.
CoarseMagnet divided(const Vec3& low, const Vec3& high) {
  const Vec3 edges = high - low;
  int count[3] = {1, 1, 1};
  for (;;) {
    const Vec3 part(edges[0] / count[0], edges[1] / count[1], edges[2] / count[2]);
    int axis;
    const double longest = part.maxCoeff(&axis);
    if (longest <= longest_part * std::cbrt(part.prod()) || count[0] * count[1] * count[2] * 2 > most_parts) {
      CoarseMagnet coarse;
      coarse.positions.resize(count[0] * count[1] * count[2], 3);
      Index row = 0;
      for (int i = 0; i < count[0]; ++i)
        for (int j = 0; j < count[1]; ++j)
          for (int k = 0; k < count[2]; ++k)
            coarse.positions.row(row++) = (low + part.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5))).transpose();
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
  } else if (const DipoleSet* set = source.dipoles(); set && set->positions().rows() > 0) {
    coarse.positions = set->positions();
    coarse.moment = set->moments().rowwise().norm().maxCoeff();
    return coarse;
  } else {
    coarse.positions = Points::Zero(1, 3);
    coarse.size = source.radius();
  }
  coarse.moment = source.moment().norm() / static_cast<double>(coarse.positions.rows());
  return coarse;
}

double largest_frequency2(const std::vector<CoarseMagnet>& magnets, const std::vector<RigidPose>& poses,
                          const std::vector<Index>& carrier, const std::vector<Carrier>& carriers, double field) {
  std::vector<double> frequency2(carriers.size(), 0.0);
  std::vector<Points> world(magnets.size());
  for (std::size_t i = 0; i < magnets.size(); ++i) {
    world[i].resize(magnets[i].positions.rows(), 3);
    place_points(poses[i], magnets[i].positions, world[i]);
    frequency2[carrier[i]] += magnets[i].moment * static_cast<double>(world[i].rows()) * field *
                              carriers[carrier[i]].inverse_inertia;
  }
  for (std::size_t i = 0; i < magnets.size(); ++i) {
    for (std::size_t k = i + 1; k < magnets.size(); ++k) {
      const Carrier &a = carriers[carrier[i]], &b = carriers[carrier[k]];
      if (carrier[i] == carrier[k] || (a.inverse_mass == 0.0 && a.inverse_inertia == 0.0 && b.inverse_mass == 0.0 &&
                                       b.inverse_inertia == 0.0))
        continue;
      const double closest = 0.5 * (magnets[i].size + magnets[k].size);
      const double strength = mu0 / (4.0 * pi) * magnets[i].moment * magnets[k].moment;
      double pair = 0.0;
      for (Eigen::Index p = 0; p < world[i].rows(); ++p) {
        for (Eigen::Index q = 0; q < world[k].rows(); ++q) {
          const double r = std::max((world[i].row(p) - world[k].row(q)).norm(), closest);
          if (r == 0.0) continue;
          const double cube = strength / (r * r * r), force = 24.0 * cube / (r * r), torque = 2.0 * cube;
          const double arm_a = (world[i].row(p).transpose() - a.centre).squaredNorm();
          const double arm_b = (world[k].row(q).transpose() - b.centre).squaredNorm();
          pair += force * (a.inverse_mass + b.inverse_mass + arm_a * a.inverse_inertia + arm_b * b.inverse_inertia) +
                  torque * (a.inverse_inertia + b.inverse_inertia);
        }
      }
      frequency2[carrier[i]] += pair;
      frequency2[carrier[k]] += pair;
    }
  }
  return frequency2.empty() ? 0.0 : *std::max_element(frequency2.begin(), frequency2.end());
}

}  // namespace loomstone
