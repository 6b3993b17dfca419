// Tests of fluxes and forces between bodies with many panels, compared with sums over all pairs
// of panels.
#include <random>

#include <catch2/catch.hpp>

#include "core/magnetics/forces/panel_wrench.h"
#include "core/magnetics/induction/mutual_fluxes.h"
#include "core/magnetics/sources/constants.h"

using namespace loomstone;

namespace {

// Tolerances relative to the size of fluxes and forces. Clusters of panels that are far apart
// interact by interpolation at 6 nodes in each direction. In forces, the errors of interpolation
// partly cancel.
constexpr double flux_tolerance = 3e-6, force_tolerance = 1e-6;

// Panels of a flat cuboid in a coarse and a fine grid, with the weights 1 - share and share.
PanelSet flat_cuboid(double share) {
  std::vector<FlatPanel> panels = cuboid_panels(Vec3(3, 2, 0.4), 4, 0.0);
  const auto coarse = static_cast<Index>(panels.size());
  for (const FlatPanel& panel : cuboid_panels(Vec3(3, 2, 0.4), 8, 0.0)) panels.push_back(panel);
  const auto all = static_cast<Index>(panels.size());
  return {std::move(panels), 3, {{0, coarse, 1.0 - share}, {coarse, all, share}}};
}
PanelSet cylinder() {
  std::vector<FlatPanel> panels = cylinder_panels(1.0, 0.0, 1.0, 16);
  const auto all = static_cast<Index>(panels.size());
  return {std::move(panels), 3, {{0, all, 1.0}}};
}

// Returns charges that vary smoothly, plus a random part.
Vector charges_of(const PanelSet& set, int seed) {
  std::mt19937 random(seed);
  Vector charges(set.panels.size());
  for (Eigen::Index i = 0; i < charges.size(); ++i) {
    const Vec3& x = set.panels[i].centre;
    charges[i] = x[2] + 0.3 * x[0] * x[1] + 0.2 * (random() / 4294967296.0 - 0.5);
  }
  return charges;
}

// Computes the fluxes directly, by sums over all panels of the grids that interact.
Vector all_fluxes(const PanelSet& on, const RigidPose& pose, const PanelSet& by,
                  const Vector& charges) {
  Vector fluxes = Vector::Zero(on.panels.size());
  for (const GridPair& grids : interacting_grids(on, by)) {
    const auto &to = grids.one, &from = grids.other;
    fluxes.segment(to.begin, to.end - to.begin) +=
        panel_fluxes({on, to.begin, to.end}, pose, {by, from.begin, from.end}) *
        charges.segment(from.begin, from.end - from.begin) / grids.share;
  }
  return fluxes;
}

Wrench all_forces(const PlacedCharges& on, const PlacedCharges& by) {
  Wrench sum;
  const RigidPose pose = relative_pose(on.pose, by.pose);
  const Mat3 rotation = rotation_matrix(pose.orientation),
             out = rotation_matrix(by.pose.orientation);
  for (const GridPair& grids : interacting_grids(on.set, by.set)) {
    for (Index i = grids.one.begin * 9; i < grids.one.end * 9; i += 8) {
      const Index n = std::min<Index>(8, grids.one.end * 9 - i);
      Eigen::Matrix<double, 8, 3> x, field;
      for (Index k = 0; k < 8; ++k)
        x.row(k) =
            (pose.position + rotation * on.set.samples.row(i + std::min(k, n - 1)).transpose())
                .transpose();
      panel_field({by.set, grids.other.begin, grids.other.end},
                  by.charges.data() + grids.other.begin, x.data(), 8, field.data());
      for (Index k = 0; k < n; ++k) {
        const Index panel = (i + k) / 9;
        const Vec3 force = on.charges[panel] * on.set.shares[i + k] * on.set.panels[panel].area /
                           (mu0 * grids.share) * (out * field.row(k).transpose());
        const Vec3 arm =
            rotation_matrix(on.pose.orientation) * on.set.samples.row(i + k).transpose();
        sum.force += force;
        sum.torque += arm.cross(force);
      }
    }
  }
  return sum;
}

// Poses of a flat cuboid relative to an equal one: two parallel, one tilted, one turned about z.
// The gaps are 0.1 to 1 times the height.
const std::vector<RigidPose> poses = {{Vec3(0, 0, 0.44), Vec4(1, 0, 0, 0)},
                                      {Vec3(0.3, -0.2, 0.5), Vec4(1, 0, 0, 0)},
                                      {Vec3(2.1, 0.4, 1.1), Vec4(0.8, 0.2, 0.4, -0.4)},
                                      {Vec3(3.2, 0.1, 0), Vec4(0.6, 0, 0, 0.8)}};

}  // namespace

TEST_CASE("fluxes between bodies equal sums over all panels") {
  const PanelSet cuboid = flat_cuboid(4.0 / 3.0), other = flat_cuboid(1.5), round = cylinder();
  const Vec3 above(0, 0, 1.3);
  struct Case {
    const PanelSet &on, &by;
    RigidPose pose;
  };
  // In the first case, the grids of the two panel sets have different weights. In the next three,
  // at least one set has a curved surface. In the cases added below, the weights are equal.
  std::vector<Case> cases = {{cuboid, other, poses[1]},
                             {round, cuboid, {Vec3(0.2, 0.1, 0.8), Vec4(1, 0, 0, 0)}},
                             {cuboid, round, {Vec3(0.2, 0.1, 0.8), Vec4(1, 0, 0, 0)}},
                             {round, round, {above, Vec4(0.8, 0, 0, 0.6)}}};
  for (const RigidPose& pose : poses) cases.push_back({cuboid, cuboid, pose});
  for (const Case& each : cases) {
    const Vector charges = charges_of(each.by, 1);
    const Vector wanted = all_fluxes(each.on, each.pose, each.by, charges);
    Vector found = Vector::Zero(wanted.size());
    MutualFluxes(Team{}, each.on, each.pose, each.by).add(Team{}, charges, found);
    CHECK((found - wanted).norm() < flux_tolerance * wanted.norm());
  }
}

TEST_CASE("forces between bodies equal sums over all panels and are opposite") {
  const PanelSet cuboid = flat_cuboid(4.0 / 3.0);
  const Vector one = charges_of(cuboid, 1), two = charges_of(cuboid, 2);
  const RigidPose origin{Vec3(0.1, 0.2, 0.3), Vec4(1, 0, 0, 0)};
  for (const RigidPose& pose : poses) {
    const RigidPose there{origin.position + pose.position, pose.orientation};
    const PlacedCharges on{cuboid, one, there}, by{cuboid, two, origin};
    const Wrench wanted = all_forces(on, by), found = panel_wrench(on, by),
                 back = panel_wrench(by, on);
    CHECK((found.force - wanted.force).norm() < force_tolerance * wanted.force.norm());
    CHECK((found.torque - wanted.torque).norm() < force_tolerance * wanted.force.norm());
    // The two forces are sampled on different bodies, so they are not exactly opposite. The charges
    // jump between coarse panels, and the samples do not resolve these jumps exactly.
    CHECK((found.force + back.force).norm() < 2e-4 * wanted.force.norm());
  }
}

TEST_CASE("fluxes between bodies have the same bits on any number of threads") {
  const PanelSet cuboid = flat_cuboid(4.0 / 3.0);
  const Vector charges = charges_of(cuboid, 1);
  Vector one = Vector::Zero(charges.size());
  MutualFluxes(Team{}, cuboid, poses[2], cuboid).add(Team{}, charges, one);
  for (const int threads : {2, 3}) {
    const Team team{threads};
    Vector many = Vector::Zero(charges.size());
    MutualFluxes(team, cuboid, poses[2], cuboid).add(team, charges, many);
    CHECK(one == many);
  }
}
