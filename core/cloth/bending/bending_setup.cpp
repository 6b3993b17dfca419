#include "core/cloth/bending/bending_setup.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Eigenvalues>

#include "core/base/message.h"

namespace loomstone {

namespace {

[[noreturn]] void refuse_size(const char* field, const char* expected, std::size_t wanted,
                              std::size_t got) {
  fail<InvalidInput>(
      "bending: {} must have one entry per {} ({}), got {}; build it from the same mesh", field,
      expected, wanted, got);
}

[[noreturn]] void refuse(const char* field, Index item, const char* must, double got,
                         const char* remedy) {
  fail<InvalidInput>("bending: {}[{}] must be {}, got {}; {}", field, item, must, got, remedy);
}

}  // namespace

void check_bending_setup(const BendingSetup& setup) {
  const std::size_t m = setup.triangles.rows(), n = setup.rest_positions.rows();
  if (setup.corners.size() != m) refuse_size("corners", "triangle", m, setup.corners.size());
  if (setup.rigidity.size() != m) refuse_size("rigidity", "triangle", m, setup.rigidity.size());
  if (setup.damping.size() != m) refuse_size("damping", "triangle", m, setup.damping.size());
  if (setup.prescribed.size() != n) refuse_size("prescribed", "vertex", n, setup.prescribed.size());
  if (!setup.acts.empty() && setup.acts.size() != m)
    refuse_size("acts", "triangle", m, setup.acts.size());
  for (Index t = 0; t < static_cast<Index>(m); ++t) {
    const Corners2& x = setup.corners[t];
    const Vec2 e1 = (x.row(1) - x.row(0)).transpose(), e2 = (x.row(2) - x.row(0)).transpose();
    const double area = 0.5 * (e1.x() * e2.y() - e1.y() * e2.x());
    if (!(area > 1e-12 * std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()})))
      refuse("corners", t,
             "three points with a rest area > 1e-12 of the longest edge squared [m^2]", area,
             "remove the triangle or turn its corners counter-clockwise");
    const Mat3& d = setup.rigidity[t];
    if (!d.allFinite() || d != d.transpose())
      fail<InvalidInput>(
          "bending: rigidity[{}] must be finite and symmetric, got rows ({}, {}, {}), ({}, {}, {}) "
          "and ({}, {}, {}); give finite bending_weft, bending_warp, bending_twist and "
          "bending_coupling [N m]",
          t, d(0, 0), d(0, 1), d(0, 2), d(1, 0), d(1, 1), d(1, 2), d(2, 0), d(2, 1), d(2, 2));
    const Vec3 eigenvalues =
        Eigen::SelfAdjointEigenSolver<Mat3>(d, Eigen::EigenvaluesOnly).eigenvalues();
    if (eigenvalues(0) < -1e-12 * eigenvalues(2))
      fail<InvalidInput>(
          "bending: rigidity[{}] must be positive semi-definite (bending_coupling^2 <= "
          "bending_weft * bending_warp), got an eigenvalue of {}; lower bending_coupling",
          t, eigenvalues(0));
    if (!(setup.damping[t] >= 0.0) || !std::isfinite(setup.damping[t]))
      refuse("damping", t, ">= 0 [s]", setup.damping[t], "negative damping would add energy");
  }
  for (Index e = 0; e < static_cast<Index>(setup.rest_angles.size()); ++e)
    if (!(std::abs(setup.rest_angles[e]) < M_PI))
      refuse("rest_angles", e, "in (-pi, pi) [rad]", setup.rest_angles[e],
             "give angles in radians");
}

HingeSet make_hinge_set(const BendingSetup& setup, const EdgeTable& edges) {
  std::vector<Hinge> list = hinges(setup.triangles, edges);
  std::vector<double> rest(list.size(), 0.0);
  if (!setup.rest_angles.empty()) {
    if (setup.rest_angles.size() != list.size())
      refuse_size("rest_angles", "hinge", list.size(), setup.rest_angles.size());
    rest = setup.rest_angles;
  } else if (!setup.flat_rest) {
    rest = measure_angles(list, setup.rest_positions);
  }
  return HingeSet(static_cast<Index>(setup.rest_positions.rows()), std::move(list),
                  std::move(rest));
}

std::vector<Index> all_of(Index n) {
  std::vector<Index> list(n);
  std::iota(list.begin(), list.end(), 0);
  return list;
}

double power_iteration(const HingeSet& hinges, const Points& rest_positions,
                       const std::vector<std::uint8_t>& prescribed, const Vector& mass,
                       const std::function<void(const HingeValues&, AlignedDoubles&)>& moments) {
  constexpr int iterations = 40;  // our choice; the eigenvalue is slightly underestimated
  const Team team;
  const Index n = static_cast<Index>(rest_positions.rows());
  const std::vector<Index> batches = all_of(hinges.n_batches());
  HingeRange range;
  hinges.find_range(0, n, range);
  HingeValues values;
  AlignedDoubles moment(values.difference.size());
  Points v(n, 3), force(n, 3);
  std::uint64_t bits = 0x9e3779b97f4a7c15u;  // fixed seed of a xorshift generator
  for (Index i = 0; i < n; ++i)
    for (int d = 0; d < 3; ++d) {
      bits ^= bits << 13, bits ^= bits >> 7, bits ^= bits << 17;
      v(i, d) = prescribed[i] ? 0.0 : static_cast<double>(bits >> 11) * 0x1p-53 - 0.5;
    }
  double eigenvalue = 0.0;
  for (int k = 0; k < iterations; ++k) {
    double norm = 0.0;  // v . M v
    for (Index i = 0; i < n; ++i) norm += mass[i] * v.row(i).squaredNorm();
    if (!(norm > 0.0)) return 0.0;
    v /= std::sqrt(norm);
    hinges.evaluate(team, batches, rest_positions, &v, true, values);
    moments(values, moment);
    force.setZero();
    hinges.gather(team, values, moment, range, force);
    eigenvalue = -(force.array() * v.array()).sum();  // Rayleigh quotient <= largest eigenvalue
    for (Index i = 0; i < n; ++i)
      if (!prescribed[i]) v.row(i) = -force.row(i) / mass[i];
  }
  return eigenvalue;
}

}  // namespace loomstone
