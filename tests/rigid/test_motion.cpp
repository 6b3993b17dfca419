// Tests of the motion of bodies without contacts.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/base/rotation.h"
#include "tests/rigid/worlds.h"

using namespace loomstone;

namespace {

double spin_energy(const RigidState& state, const MassProperties& mass) {
  const Vec3 omega = state.angular_velocities.row(0).transpose();
  return 0.5 * omega.dot(world_inertia(mass, state.orientations.row(0).transpose()) * omega);
}

Vec3 spin_momentum(const RigidState& state, const MassProperties& mass) {
  return world_inertia(mass, state.orientations.row(0).transpose()) *
         state.angular_velocities.row(0).transpose();
}

}  // namespace

TEST_CASE("a falling sphere follows symplectic Euler to rounding") {
  RigidBody sphere = body_of(icosphere(0.1, 3), "sphere", Vec3(0, 0, 2));
  sphere.velocity = Vec3(1.0, 0.5, 3.0);
  RigidWorld world({sphere}, {}, Vec3(0, 0, -9.81));
  RigidState state = world.initial_state();
  const double h = 1e-3;
  const int n = 500;
  run(world, state, h, n, 0);
  // v_n = v0 + n h g, x_n = x0 + n h v0 + n (n + 1) / 2 h^2 g. The tolerance allows for 500
  // rounding errors of numbers of about one, with a margin.
  const Vec3 g(0, 0, -9.81);
  CHECK((state.velocities.row(0).transpose() - (sphere.velocity + n * h * g)).norm() < 1e-12);
  CHECK((state.positions.row(0).transpose() -
         (sphere.position + n * h * sphere.velocity + 0.5 * n * (n + 1) * h * h * g))
            .norm() < 1e-12);
  CHECK(state.angular_velocities.norm() == 0.0);
}

TEST_CASE("a free body keeps its momenta to rounding and its energy to second order in the step") {
  // A bar that spins about its intermediate axis tumbles. The mesh is rotated and shifted, so the
  // principal axes of the bar are not the mesh axes and its centre of mass is not the origin.
  RigidBody bar = body_of(box(0.4, 0.2, 0.1).moved(Vec3(0.3, 0.1, -0.2), turn), "convex");
  bar.velocity = Vec3(1, 2, 3);
  bar.angular_velocity = turn * Vec3(0.1, 5.0, 0.1);
  double energy_error[2];
  for (int refinement = 0; refinement < 2; ++refinement) {
    RigidWorld world({bar}, {}, Vec3::Zero());
    RigidState state = world.initial_state();
    const MassProperties& mass = world.mass_properties()[0];
    const double energy = spin_energy(state, mass);
    const Vec3 momentum = spin_momentum(state, mass);
    const Vec3 start = state.positions.row(0).transpose();
    const int n = 500 << refinement;
    run(world, state, 1.0 / n, n, 0);
    CHECK((state.velocities.row(0).transpose() - bar.velocity).norm() < 1e-13);
    CHECK((state.positions.row(0).transpose() - start - bar.velocity).norm() < 1e-11);
    energy_error[refinement] = std::abs(spin_energy(state, mass) / energy - 1.0);
    CHECK((spin_momentum(state, mass) - momentum).norm() < 1e-12 * momentum.norm());
  }
  CHECK(energy_error[0] < 1e-4);
  CHECK(energy_error[1] < 0.3 * energy_error[0]);
}

TEST_CASE("a body described in rotated mesh axes has the same motion") {
  RigidBody plain = body_of(box(0.4, 0.2, 0.1), "box", Vec3(1, 2, 3));
  plain.velocity = Vec3(1, 0, 0);
  plain.angular_velocity = Vec3(1, 2, -3);
  // The mesh is rotated by `turn` and shifted. The pose of the body undoes both.
  RigidBody turned_mesh = plain;
  turned_mesh.shape = BodyShape::Convex;
  const Vec3 shift(0.5, -0.5, 0.25);
  turned_mesh.mesh = shared(plain.mesh->moved(shift, turn));
  turned_mesh.orientation = quaternion_from_matrix(turn.transpose());
  turned_mesh.position = plain.position - turn.transpose() * shift;
  RigidWorld one({plain}, {}, Vec3::Zero()), two({turned_mesh}, {}, Vec3::Zero());
  RigidState a = one.initial_state(), b = two.initial_state();
  CHECK((a.positions - b.positions).norm() < 1e-14);
  run(one, a, 1e-3, 300, 0);
  run(two, b, 1e-3, 300, 0);
  // The tolerances allow for rounding in 300 steps, which depends on the mesh axes. Rounding
  // errors grow slowly, because the motion is not chaotic.
  CHECK((a.positions - b.positions).norm() < 1e-12);
  CHECK((a.angular_velocities - b.angular_velocities).norm() < 1e-11);
  const Points xa = world_vertices(a, 0, *plain.mesh, one.mass_properties()[0]);
  const Points xb = world_vertices(b, 0, *turned_mesh.mesh, two.mass_properties()[0]);
  CHECK((xa - xb).norm() < 1e-11);
}

TEST_CASE("impulses change velocities by mass and inertia before the step") {
  RigidBody bar = body_of(box(0.4, 0.2, 0.1).moved(Vec3::Zero(), turn), "convex", Vec3(0, 0, 1));
  RigidWorld world({bar}, {}, Vec3::Zero());
  RigidState state = world.initial_state();
  const Vec3 start = state.positions.row(0).transpose();
  const MassProperties mass = world.mass_properties()[0];
  Points impulse(1, 3), angular(1, 3);
  impulse << 1.0, -2.0, 0.5;
  // The rotation is so slow that its gyroscopic change within the step is below the tolerance.
  angular << 1e-4, 2e-4, -3e-4;
  const double h = 1e-3;
  world.advance(h, {impulse, angular}, {}, state);
  const Vec3 velocity = impulse.row(0).transpose() / mass.mass;
  const Vec3 omega = mass.inertia.inverse() * angular.row(0).transpose();
  CHECK((state.velocities.row(0).transpose() - velocity).norm() < 1e-14);
  CHECK((state.positions.row(0).transpose() - start - h * velocity).norm() < 1e-14);
  CHECK((state.angular_velocities.row(0).transpose() - omega).norm() <
        2.0 * h * omega.squaredNorm());
}

TEST_CASE("a body whose state has been set continues from it") {
  RigidBody sphere = body_of(icosphere(0.1, 2), "sphere");
  RigidWorld world({sphere, sphere}, {}, Vec3::Zero());
  RigidState state = world.initial_state();
  state.positions.row(1) = Vec3(3, 0, 0).transpose();
  run(world, state, 1e-3, 10, 0);
  state.velocities.row(0) = Vec3(0, 1, 0).transpose();
  run(world, state, 1e-3, 100, 0);
  CHECK((state.positions.row(0) - Vec3(0, 0.1, 0).transpose()).norm() < 1e-14);
  CHECK((state.positions.row(1) - Vec3(3, 0, 0).transpose()).norm() < 1e-14);
}

TEST_CASE("points of a body go to the world and back, and move with its velocity field") {
  RigidBody bar = body_of(box(0.4, 0.2, 0.1), "box", Vec3(1, 2, 3));
  bar.orientation = quaternion_from_matrix(turn);
  bar.velocity = Vec3(1, 0, -1);
  bar.angular_velocity = Vec3(0.5, 1.0, -2.0);
  RigidWorld world({bar}, {}, Vec3::Zero());
  RigidState state = world.initial_state();
  const Vec3 local(0.1, -0.05, 0.02);
  const Vec3 before = to_world(state, 0, local), velocity = velocity_at(state, 0, before);
  CHECK((to_body(state, 0, before) - local).norm() < 1e-14);
  CHECK((before - (bar.position + turn * local)).norm() < 1e-14);
  const double h = 1e-5;
  run(world, state, h, 1, 0);
  // The difference quotient has an error of h omega^2 r / 2 = 3e-6. The gyroscopic change of omega
  // has an effect of the same order, and the tolerance has a margin.
  CHECK(((to_world(state, 0, local) - before) / h - velocity).norm() < 1e-4);
}

TEST_CASE("a ball and a cube turn by the angle of their spin, however fast they spin") {
  const bool round = GENERATE(true, false);
  const double spin = GENERATE(20.0, 900.0, 5000.0), step = GENERATE(1e-3, 2.5e-3);
  CAPTURE(round, spin, step);
  RigidBody body =
      round ? body_of(icosphere(0.02, 3), "sphere") : body_of(box(0.02, 0.02, 0.02), "box");
  const Vec3 axis = Vec3(0.6, 0.0, 0.8);
  body.angular_velocity = spin * axis;
  RigidWorld world({body}, {}, Vec3::Zero());
  RigidState state = world.initial_state();
  run(world, state, step, 40, 0);
  const Mat3 expected = rotation_matrix(quaternion_from_rotation_vector(40 * step * spin * axis));
  const Mat3 found = rotation_matrix(state.orientations.row(0).transpose());
  CHECK((found - expected).norm() < 1e-9);
}
