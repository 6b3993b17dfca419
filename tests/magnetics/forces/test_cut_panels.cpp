// Tests of panels that are cut along the faces of a cuboid, and of forces that use them.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/magnetics/forces/cut_panels.h"
#include "core/magnetics/forces/interaction.h"
#include "core/magnetics/sources/polyhedron.h"
#include "core/mesh/generators.h"

using namespace loomstone;

namespace {

const Vec3 size(0.01, 0.008, 0.006), polarization(0.3, 0.2, 1.2);

// Pose of a cuboid of this size that stands on an equal one, turned about the vertical axis. Its
// lowest corner is `gap` above the upper face of the other one.
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

// Without the cuts, two million points of the field would not suffice for this tolerance. The mesh
// of the same shape is not a cuboid to the code, so its panels are not cut.
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
