// Tests of panels that are cut where the field of a cuboid or cylinder is singular, and of forces
// that use them.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "core/magnetics/forces/cut_panels.h"
#include "core/magnetics/forces/interaction.h"
#include "core/magnetics/sources/axisymmetric.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/gauss.h"
#include "core/magnetics/sources/polyhedron.h"
#include "core/mesh/generators.h"

using namespace loomstone;

namespace {

const Vec3 size(0.01, 0.008, 0.006), polarization(0.3, 0.2, 1.2);

// Pose of a cuboid that stands on an equal one. It is tilted by `tilt` [rad] and turned about the
// vertical axis by `yaw` [rad]. Its lowest corner is `gap` [m] above the other cuboid's upper face.
RigidPose standing(double yaw, double tilt, double gap) {
  const Vec4 orientation =
      quaternion_product(quaternion_from_rotation_vector(Vec3(0, 0, yaw)),
                         quaternion_from_rotation_vector(tilt * Vec3(0.8, 0.6, 0.0)));
  const Mat3 turn = rotation_matrix(orientation);
  const double reach = 0.5 * turn.row(2).cwiseAbs().dot(size.transpose());
  return {Vec3(0.0012, 0.0007, 0.5 * size.z() + gap + reach), orientation};
}

}  // namespace

TEST_CASE("cut panels cover the panel, and no face plane passes through a triangle") {
  const RigidPose pose = standing(0.4, GENERATE(0.0, 1e-3, 0.3), 1e-6);
  const Mat3 turn = rotation_matrix(pose.orientation);
  Panel panel{Panel::Shape::parallelogram};
  panel.a = Vec3(-0.005, -0.004, -0.003), panel.b = Vec3(0.01, 0, 0), panel.c = Vec3(0, 0.008, 0);
  panel.magnetization = Vec3(0, 0, 1);
  Vec3 area = Vec3::Zero(), moment = Vec3::Zero();
  const std::vector<Panel> triangles = cut_along_faces(panel, pose, {size, polarization});
  CHECK(triangles.size() > 4);  // an uncut panel gives 4
  for (const Panel& triangle : triangles) {
    const Vec3 normal = 0.5 * triangle.b.cross(triangle.c);
    area += normal;
    moment += normal.z() * (triangle.a + (triangle.b + triangle.c) / 3.0);
    for (const int axis : {0, 1, 2})
      for (const double side : {-0.5, 0.5}) {
        double low = 1.0, high = -1.0;
        for (const Vec3& x :
             {triangle.a, Vec3(triangle.a + triangle.b), Vec3(triangle.a + triangle.c)}) {
          const double height = (pose.position + turn * x)[axis] - side * size[axis];
          low = std::min(low, height), high = std::max(high, height);
        }
        CHECK((low > -1e-10 || high < 1e-10));
      }
  }
  CHECK((area - panel.b.cross(panel.c)).norm() < 1e-12 * panel.b.cross(panel.c).norm());
  CHECK((moment - area.z() * Vec3(0, 0, -0.003)).norm() < 1e-12 * 0.005 * area.norm());
}

// Without the cuts, two million evaluations of the field would not reach the tolerance of 1e-7. The
// panels of the mesh are not cut, because the code does not recognise its shape as a cuboid.
TEST_CASE("forces between cuboids that lie flush and turned reach a small tolerance") {
  const double tilt = GENERATE(0.0, 1e-4, 1e-2), gap = GENERATE(1e-9, 1e-6);
  CAPTURE(tilt, gap);
  const auto cuboid = std::make_shared<Cuboid>(size, polarization);
  const TriangleMesh mesh = box(size.x(), size.y(), size.z());
  const auto polyhedron = std::make_shared<MeshMagnet>(mesh, polarization);
  const MagneticBody below{cuboid, {Vec3::Zero(), Vec4(1, 0, 0, 0)}},
      above{cuboid, standing(0.4, tilt, gap)};
  const double tolerance = 1e-7;
  const Wrench fine = magnetic_wrench(above, below, tolerance, 0.0);
  const double largest = std::max(fine.force.norm(), fine.torque.norm() / cuboid->radius());
  CHECK(fine.error <= tolerance * largest);
  const Wrench uncut =
      magnetic_wrench({polyhedron, above.pose}, {polyhedron, below.pose}, 1e-4, 0.0);
  CHECK((fine.force - uncut.force).norm() < 1e-4 * largest);
  CHECK((fine.torque - uncut.torque).norm() < 1e-4 * largest * cuboid->radius());
}

namespace {

// Area of a part of a disc [m^2], and the smallest and largest values of r - R over the part [m].
// Here r is the distance from the axis of a cylinder, and R is the radius of its inner rim (index
// 0) or outer rim (index 1).
struct PartOfDisc {
  double area = 0.0;
  double low[2] = {1.0, 1.0}, high[2] = {-1.0, -1.0};

  PartOfDisc(const Panel& part, const RigidPose& pose, const UniformCylinder& rims) {
    const Mat3 turn = rotation_matrix(pose.orientation);
    const GaussRule& rule = gauss_rule(10);
    for (int i = 0; i < rule.n * rule.n; ++i) {
      const int iu = i / rule.n, iv = i % rule.n;
      const PanelSample sample =
          part.at(0.5 * (1.0 + rule.nodes[iu]), 0.5 * (1.0 + rule.nodes[iv]));
      area -= 0.25 * rule.weights[iu] * rule.weights[iv] * sample.area.z();
      const Vec3 x = pose.position + turn * sample.position;
      for (const int side : {0, 1}) {
        const double out = std::hypot(x.x(), x.y()) - (side == 0 ? rims.inner_radius : rims.radius);
        low[side] = std::min(low[side], out), high[side] = std::max(high[side], out);
      }
    }
  }
};

}  // namespace

TEST_CASE("cut discs cover the disc, and no rim passes through a part") {
  const double inner = GENERATE(0.0, 0.002), hole = GENERATE(0.0, 0.0035);
  const double radius = 0.006, rim = GENERATE(0.005, 0.006, 0.009),
               off = GENERATE(0.0, 1e-3, 3e-3, 4e-3);
  CAPTURE(inner, hole, rim, off);
  const RigidPose pose{Vec3(0.6 * off, 0.8 * off, 0.004),
                       quaternion_from_rotation_vector(Vec3(0.01, 0.02, 0.7))};
  double area = 0.0;
  std::size_t n_parts = 0;
  for (const Panel& panel : Cylinder(radius, 0.004, Vec3(0, 0, 1), inner).panels()) {
    if (panel.height0 > 0.0) continue;
    for (const Panel& part : cut_along_rims(panel, pose, {rim, hole})) {
      const PartOfDisc found(part, pose, {rim, hole});
      area += found.area;
      ++n_parts;
      // The tilt of 0.022 rad moves a projected rim by up to 0.022^2 / 2 of its radius.
      if (hole > off) CHECK((found.low[0] > -3e-6 || found.high[0] < 3e-6));
      CHECK((found.low[1] > -3e-6 || found.high[1] < 3e-6));
    }
  }
  CHECK(n_parts >= 4);
  CHECK(std::abs(area - pi * (radius * radius - inner * inner)) < 1e-9 * area);
}

TEST_CASE("discs that a cuboid cuts cover the disc, and no face plane passes through a part") {
  const double inner = GENERATE(0.0, 0.002), tilt = GENERATE(0.0, 1e-3, 0.3, 1.4);
  const Vec3 at = GENERATE(Vec3(0.0012, 0.0007, 0.006), Vec3(0.005, 0.004, 0.0), Vec3(0, 0, 0.006));
  CAPTURE(inner, tilt, at.transpose());
  const RigidPose pose{
      at, quaternion_product(quaternion_from_rotation_vector(Vec3(0, 0, 0.4)),
                             quaternion_from_rotation_vector(tilt * Vec3(0.8, 0.6, 0.0)))};
  const Mat3 turn = rotation_matrix(pose.orientation);
  const double radius = 0.006;
  double area = 0.0;
  for (const Panel& panel : Cylinder(radius, 0.004, Vec3(0, 0, 1), inner).panels()) {
    if (panel.shape != Panel::Shape::disc || panel.height0 > 0.0) continue;
    for (const Panel& part : cut_disc_along_faces(panel, pose, {size, polarization})) {
      std::array<double, 6> low, high;
      low.fill(1.0), high.fill(-1.0);
      const GaussRule& rule = gauss_rule(10);
      for (int i = 0; i < 100; ++i) {
        const PanelSample sample =
            part.at(0.5 + 0.5 * rule.nodes[i / 10], 0.5 + 0.5 * rule.nodes[i % 10]);
        area += 0.25 * rule.weights[i / 10] * rule.weights[i % 10] * std::abs(sample.area.z());
        const Vec3 x = pose.position + turn * sample.position;
        for (int side = 0; side < 6; ++side) {
          const double height = x[side / 2] - (side % 2 - 0.5) * size[side / 2];
          low[side] = std::min(low[side], height), high[side] = std::max(high[side], height);
        }
      }
      for (int side = 0; side < 6; ++side) CHECK((low[side] > -1e-9 || high[side] < 1e-9));
    }
  }
  CHECK(area == Approx(pi * (radius * radius - inner * inner)).epsilon(1e-6));
}

// Without the cuts, two million evaluations of the field would not reach the tolerance of 1e-6.
TEST_CASE("the force of a cuboid on a disc that lies flush is the derivative of the energy") {
  const double off = GENERATE(3e-4, 4e-3), inner = GENERATE(0.0, 0.002);
  CAPTURE(off, inner);
  const auto below = std::make_shared<Cuboid>(size, polarization);
  const auto above = std::make_shared<Cylinder>(0.004, 0.003, Vec3(0, 0.3, 1.0), inner);
  const auto at = [&](double x) {
    return MagneticBody{above, {Vec3(x, 2e-4, 0.0045 + 1e-9), Vec4(1, 0, 0, 0)}};
  };
  const MagneticBody fixed{below, {Vec3::Zero(), Vec4(1, 0, 0, 0)}};
  const Wrench wrench = magnetic_wrench(at(off), fixed, 1e-6, 0.0);
  const double norm = std::max(wrench.force.norm(), wrench.torque.norm() / above->radius());
  CHECK(wrench.error <= 1e-6 * norm);
  const double step = 1e-5;
  const double slope = (magnetic_energy(at(off + step), fixed, 1e-9) -
                        magnetic_energy(at(off - step), fixed, 1e-9)) /
                       (2 * step);
  CHECK(wrench.force.x() == Approx(-slope).margin(1e-4 * norm));
}

TEST_CASE(
    "discs are not cut if their axes differ or a rim does not surround the axis of the disc") {
  const Panel panel = Cylinder(0.006, 0.004, Vec3(0, 0, 1)).panels().front();
  const RigidPose tilted{Vec3(0, 0, 0.01), quaternion_from_rotation_vector(Vec3(0.2, 0, 0))},
      beside{Vec3(0.007, 0, 0.004), Vec4(1, 0, 0, 0)};
  CHECK(cut_along_rims(panel, tilted, {0.006, 0.0}).empty());
  CHECK(cut_along_rims(panel, beside, {0.006, 0.0}).empty());
}

// Without the cuts, two million evaluations of the field would not reach the tolerance of 1e-7.
TEST_CASE("forces between cylinders that lie flush are derivatives of the energy") {
  const auto [off, inner] =
      GENERATE(std::pair(3e-4, 0.0), std::pair(1e-3, 0.0), std::pair(4e-3, 0.0),
               std::pair(3e-4, 0.002), std::pair(1e-3, 0.002));
  CAPTURE(off, inner);
  const auto below = std::make_shared<Cylinder>(0.006, 0.004, Vec3(0.2, 0, 1.2), inner),
             above = std::make_shared<Cylinder>(0.005, 0.003, Vec3(0, 0.3, 1.0), inner);
  const auto at = [&](double x) {
    return MagneticBody{above, {Vec3(x, 0, 0.0035 + 1e-9), Vec4(1, 0, 0, 0)}};
  };
  const MagneticBody fixed{below, {Vec3::Zero(), Vec4(1, 0, 0, 0)}};
  const Wrench wrench = magnetic_wrench(at(off), fixed, 1e-7, 0.0);
  const double size = std::max(wrench.force.norm(), wrench.torque.norm() / above->radius());
  CHECK(wrench.error <= 1e-7 * size);
  const double step = 1e-5;
  const double slope = (magnetic_energy(at(off + step), fixed, 1e-10) -
                        magnetic_energy(at(off - step), fixed, 1e-10)) /
                       (2.0 * step);
  CHECK(std::abs(wrench.force.x() + slope) < 1e-4 * size);  // the error of the difference
}
