// Tests of the free rotation of bodies.
#include <catch2/catch.hpp>

#include "core/rigid/free_motion.h"

using namespace loomstone;

namespace {

const Vec4 start = quaternion_from_rotation_vector(Vec3(0.4, -0.3, 1.1));
const Mat3 axes = rotation_matrix(quaternion_from_rotation_vector(Vec3(-0.7, 0.2, 0.5)));
const Vec3 momentum(0.3, -1.2, 0.8);

Rotor rotor_of(const Vec3& moments) {
  return make_rotor(axes * moments.asDiagonal() * axes.transpose());
}

double energy(const Rotor& rotor, const Vec4& q) {
  return 0.5 * momentum.dot(angular_velocity(rotor, q, momentum));
}

Vec4 turned_in(const Rotor& rotor, int steps, double time) {
  Vec4 q = start;
  for (int i = 0; i < steps; ++i) q = freely_turned(rotor, q, momentum, time / steps);
  return q;
}

double angle_between(const Vec4& a, const Vec4& b) {
  return angular_velocity_between(a, b, 1.0).norm();
}

}  // namespace

TEST_CASE("angular momentum and velocity are each other's inverse") {
  const Rotor rotor = rotor_of(Vec3(0.5, 1.0, 1.3));
  const Vec3 omega(0.2, -3.0, 1.0);
  CHECK((angular_velocity(rotor, start, angular_momentum(rotor, start, omega)) - omega).norm() <
        1e-14);
}

TEST_CASE("free rotation is of second order in the step") {
  const Rotor rotor = rotor_of(Vec3(0.5, 1.0, 1.3));
  const Vec4 fine = turned_in(rotor, 12800, 2.0);
  const double coarse = angle_between(turned_in(rotor, 100, 2.0), fine),
               half = angle_between(turned_in(rotor, 200, 2.0), fine);
  CHECK(coarse < 1e-2);
  CHECK(half == Approx(0.25 * coarse).epsilon(0.02));  // the next error term is of fourth order
}

TEST_CASE("free rotation can be run backwards") {
  const Rotor rotor = rotor_of(Vec3(0.5, 1.0, 1.3));
  Vec4 q = turned_in(rotor, 50, 2.0);
  for (int i = 0; i < 50; ++i) q = freely_turned(rotor, q, momentum, -0.04);
  CHECK(angle_between(q, start) < 1e-13);  // rounding of 100 steps
}

TEST_CASE("the energy of a free rotation does not drift") {
  const Rotor rotor = rotor_of(Vec3(0.5, 1.0, 1.3));
  const double first = energy(rotor, start);
  Vec4 q = start;
  double early = 0.0, late = 0.0;
  for (int i = 0; i < 40000; ++i) {
    q = freely_turned(rotor, q, momentum, 0.02);
    double& most = i < 4000 ? early : late;
    most = std::max(most, std::abs(energy(rotor, q) / first - 1.0));
  }
  CHECK(early < 1e-3);
  CHECK(late < 1.01 * early);
}

TEST_CASE("bodies with two equal moments rotate exactly at any step") {
  for (const Vec3& moments :
       {Vec3(0.5, 1.2, 1.2), Vec3(1.2, 0.5, 1.2), Vec3(1.2, 1.2, 2.0), Vec3(1.0, 1.0, 1.0)}) {
    const Rotor rotor = rotor_of(moments);
    // The tolerance covers rounding of 3,000 steps.
    CHECK(angle_between(turned_in(rotor, 1, 3.0), turned_in(rotor, 3000, 3.0)) < 1e-12);
  }
}
