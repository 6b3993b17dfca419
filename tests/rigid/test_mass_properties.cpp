// Tests of the mass, centre of mass and inertia of closed meshes.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/base/rotation.h"
#include "tests/rigid/worlds.h"

using namespace loomstone;

namespace {

// Computes the mass properties independently, from the tetrahedra that the faces form with the
// origin. Their second moments follow from a quadrature that is exact for quadratics. It has the
// weight 1/20 at each corner and 16/20 at the centroid.
MassProperties by_quadrature(const TriangleMesh& mesh, double density) {
  MassProperties result;
  Mat3 second = Mat3::Zero();
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    Vec3 x[3];
    for (int k = 0; k < 3; ++k) x[k] = mesh.vertices().row(mesh.triangles()(t, k)).transpose();
    const double mass = density * x[0].dot(x[1].cross(x[2])) / 6.0;
    const Vec3 centroid = (x[0] + x[1] + x[2]) / 4.0;
    result.mass += mass;
    result.centre += mass * centroid;
    second += mass * 16.0 / 20.0 * centroid * centroid.transpose();
    for (const Vec3& corner : x) second += mass / 20.0 * corner * corner.transpose();
  }
  result.centre /= result.mass;
  second -= result.mass * result.centre * result.centre.transpose();
  result.inertia = second.trace() * Mat3::Identity() - second;
  return result;
}

}  // namespace

TEST_CASE("a box has the mass and inertia of the closed form") {
  const double a = 0.2, b = 0.5, c = 0.03, density = 700.0;
  const MassProperties found = mass_properties(box(a, b, c, 2), density);
  const double mass = density * a * b * c;
  const Vec3 moments = mass / 12.0 * Vec3(b * b + c * c, a * a + c * c, a * a + b * b);
  CHECK(found.mass == Approx(mass).epsilon(1e-13));
  CHECK(found.centre.norm() < 1e-15);
  // The tolerance allows for rounding in sums over 48 triangles.
  CHECK((found.inertia - Mat3(moments.asDiagonal())).norm() < 1e-13 * moments.norm());
}

TEST_CASE("a sphere's mass and inertia converge with the square of the edge length") {
  const double radius = 0.3, density = 2000.0;
  const double mass = density * 4.0 / 3.0 * M_PI * std::pow(radius, 3),
               moment = 0.4 * mass * radius * radius;
  double previous_mass = 0.0, previous_moment = 0.0;
  for (int level = 2; level <= 4; ++level) {
    const MassProperties found = mass_properties(icosphere(radius, level), density);
    const double mass_error = 1.0 - found.mass / mass,
                 moment_error = 1.0 - found.inertia.trace() / (3.0 * moment);
    CHECK(mass_error > 0.0);
    if (level > 2) {
      CHECK(previous_mass / mass_error == Approx(4.0).epsilon(0.05));
      CHECK(previous_moment / moment_error == Approx(4.0).epsilon(0.05));
    }
    previous_mass = mass_error, previous_moment = moment_error;
  }
  CHECK(previous_mass < 0.003);
}

TEST_CASE("signed tetrahedra agree with a quadrature over them") {
  const TriangleMesh cone = funnel(0.3, 0.1, 0.2, 0.1, 0.01).moved(Vec3(0.1, 0.2, 0.3), turn);
  const MassProperties found = mass_properties(cone, 1200.0), other = by_quadrature(cone, 1200.0);
  CHECK(found.mass == Approx(other.mass).epsilon(1e-12));
  CHECK((found.centre - other.centre).norm() < 1e-12);
  CHECK((found.inertia - other.inertia).norm() < 1e-11 * found.inertia.norm());
}

TEST_CASE("moving and turning a mesh moves its centre and turns its inertia") {
  const TriangleMesh mesh = capsule(0.1, 0.4);
  const Vec3 shift(3.0, -5.0, 2.0);
  const MassProperties here = mass_properties(mesh, 500.0),
                       there = mass_properties(mesh.moved(shift, turn), 500.0);
  CHECK(there.mass == Approx(here.mass).epsilon(1e-12));
  CHECK((there.centre - (turn * here.centre + shift)).norm() < 1e-13);
  // Coordinates of 6 m are rounded to 1e-15 m, which is 1e-14 of the radius of the capsule.
  CHECK((there.inertia - turn * here.inertia * turn.transpose()).norm() <
        1e-11 * here.inertia.norm());
}

TEST_CASE("twice the size has eight times the mass and thirty-two times the inertia") {
  const TriangleMesh mesh = wave_bar(1.0, 0.02, 0.05, 0.5);
  const MassProperties one = mass_properties(mesh, 1.0),
                       two = mass_properties(mesh.moved(Vec3::Zero(), Mat3::Identity(), 2.0), 1.0);
  CHECK(two.mass == Approx(8.0 * one.mass).epsilon(1e-12));
  CHECK((two.inertia - 32.0 * one.inertia).norm() < 1e-12 * two.inertia.norm());
}

TEST_CASE("open, inside-out and flat meshes have no mass") {
  CHECK_THROWS_WITH(mass_properties(floor_square(1.0), 1.0), Catch::Contains("must be closed"));
  const TriangleMesh good = box(1.0, 1.0, 1.0);
  Triangles swapped = good.triangles();
  swapped.col(0).swap(swapped.col(1));
  CHECK_THROWS_WITH(mass_properties(TriangleMesh(good.vertices(), swapped), 1.0),
                    Catch::Contains("inside-out"));
  // A body flattened along an oblique direction has no volume, but every face has an area.
  const Vec3 diagonal = Vec3(1, 2, 3).normalized();
  const Points flat = good.vertices() - good.vertices() * diagonal * diagonal.transpose();
  CHECK_THROWS_WITH(mass_properties(TriangleMesh(flat, good.triangles()), 1.0),
                    Catch::Contains("volume > 0"));
}
