// Tests of the work of torques and forces that users apply to free bodies and to bodies attached to
// cloth.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <string_view>

#include "core/base/rotation.h"
#include "core/mesh/generators.h"
#include "core/sim/model/state.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// A box of 0.075 g above a sheet that is pinned at its corners. Three vertices in the middle of the
// sheet are attached to the box.
Scene small_box_on_sheet() {
  Scene scene;
  scene.gravity.setZero();
  Cloth sheet;
  sheet.name = "sheet";
  sheet.mesh = share(grid_cells(0.1, 0.1, 10, 10));
  sheet.pins = {0, 10, 110, 120};
  sheet.material.weft_stiffness = sheet.material.warp_stiffness = 500.0;
  sheet.material.shear_stiffness = 100.0;
  sheet.material.density = 0.1;
  scene.cloths.push_back(sheet);
  RigidBody small_box;
  small_box.name = "box";
  small_box.mesh = share(box(0.01, 0.01, 0.005));
  small_box.shape = BodyShape::Box;
  small_box.density = 150.0;
  small_box.position = Vec3(0, 0, 0.012);
  scene.bodies.push_back(small_box);
  scene.attachments.push_back({"sheet", "box", {60, 61, 71}});
  return scene;
}

// A cube with edges of 0.1 m, a mass of 1 kg and a moment of inertia of 1/600 kg m^2. It spins
// about the z axis at `speed` [rad/s].
Scene spinning_cube(double speed) {
  Scene scene;
  scene.gravity.setZero();
  RigidBody body;
  body.name = "cube";
  body.mesh = share(box(0.1, 0.1, 0.1));
  body.shape = BodyShape::Box;
  body.angular_velocity = Vec3(0, 0, speed);
  scene.bodies.push_back(body);
  return scene;
}

struct Pushed {
  double work = 0.0;     // torque times angle plus force times displacement [J]
  double balance = 0.0;  // largest energy balance [1]
  double energy = 0.0;   // kinetic and elastic energy at the end [J]
};

// Applies a constant torque [N m] about the y axis and a force [N] along the z axis to the body of
// a scene at rest, for 0.1 s.
Pushed push(Simulation& sim, double torque, double force) {
  sim.set_external_body_torques(Vec3(0, torque, 0).transpose());
  sim.set_external_body_forces(Vec3(0, 0, force).transpose());
  Pushed pushed;
  const RigidState& rigid = sim.state().rigid;
  const double height = rigid.positions(0, 2);
  while (sim.time() < 0.1 - 1e-9) {
    const Vec4 before = rigid.orientations.row(0).transpose();
    sim.step();
    const Vec4 after = rigid.orientations.row(0).transpose();
    pushed.work += torque * angular_velocity_between(before, after, 1.0).y();
    pushed.balance = std::max(pushed.balance, std::abs(sim.report().account.balance));
  }
  pushed.work += force * (rigid.positions(0, 2) - height);
  const EnergyReport& energy = sim.report().energy;
  pushed.energy = energy.kinetic + energy.body_kinetic + energy.membrane + energy.bending;
  return pushed;
}

}  // namespace

TEST_CASE("the work of a torque on an attached body is the torque times the angle of its turn") {
  const double step = GENERATE(1e-4, 2.5e-3);
  const std::string_view method = GENERATE("asynchronous", "semi-implicit-euler");
  Simulation sim(small_box_on_sheet(), step_of(step, method), 1);
  const Pushed pushed = push(sim, 1e-4, 0.0);
  CAPTURE(step, method, pushed.work);
  // If the work were computed from the mean of the angular velocities at both ends of each step
  // instead of the angle, its errors would be up to 8 times the work.
  CHECK(sim.report().account.loads == Approx(pushed.work).epsilon(0.01));
}

TEST_CASE("the work of a torque is the kinetic energy that it gives to a body that spins fast") {
  const double speed = GENERATE(0.0, 20.0, 500.0, -500.0), step = GENERATE(2.5e-3, 0.01);
  const Vec3 torque = GENERATE(Vec3(0, 0, 0.01), Vec3(0.01, 0, 0), Vec3(0.006, 0, -0.008));
  Simulation sim(spinning_cube(speed), step_of(step), 1);
  sim.set_external_body_torques(torque.transpose());
  const double inertia = 1.0 / 600.0;
  for (int i = 0; i < 50; ++i) sim.step();
  const double gain = sim.report().energy.body_kinetic - 0.5 * inertia * speed * speed;
  CAPTURE(speed, step, torque.transpose());
  // In a step of length h, the body turns by h times the angular velocity at the end of the step.
  // The work is therefore larger than the kinetic energy. After 50 steps from rest, the difference
  // is 1/50 of this energy. At 500 rad/s, a step of 10 ms turns the body by more than pi.
  CHECK(sim.report().account.loads == Approx(gain).epsilon(0.03));
}

TEST_CASE("the work of a torque counts whole turns of an attached body in an interval") {
  // All vertices of a patch are attached to the cube, so both turn as one rigid body.
  Scene scene = spinning_cube(GENERATE(500.0, -500.0));
  Cloth patch;
  patch.name = "patch";
  patch.mesh = share(grid_cells(0.05, 0.05, 1, 1).moved(Vec3(0, 0, 0.06)));
  scene.cloths.push_back(patch);
  scene.attachments.push_back({"patch", "cube", {0, 1, 2, 3}});
  Simulation sim(scene, step_of(0.01, "asynchronous"), 1);
  sim.step();  // the patch starts to turn
  const auto kinetic = [&] {
    return sim.report().energy.kinetic + sim.report().energy.body_kinetic;
  };
  const double start = kinetic();
  sim.set_external_body_torques(Vec3(0, 0, 0.01).transpose());
  for (int i = 0; i < 50; ++i) sim.step();
  // In every interval, the cube turns by 5 rad.
  CHECK(sim.report().account.loads == Approx(kinetic() - start).epsilon(0.01));
}

TEST_CASE(
    "torques and forces on an attached body give asynchronous cloth only the energy of their "
    "work") {
  struct Load {
    double torque, force;  // [N m, N]
  };
  const Load load = GENERATE(Load{1e-4, 0.0}, Load{1e-5, 0.0}, Load{0.0, -0.01}, Load{1e-4, -0.01});
  Simulation sim(small_box_on_sheet(), Asynchronous(), 1);
  const Pushed pushed = push(sim, load.torque, load.force);
  CAPTURE(load.torque, load.force, pushed.work, pushed.energy, pushed.balance);
  // Loads that acted only at the start of every interval would excite the box, which vibrates on
  // the sheet within an interval: energy would rise to 2.7 times the work of the torque.
  CHECK(pushed.energy == Approx(pushed.work).epsilon(0.01));
  CHECK(pushed.balance < 0.01);
}

TEST_CASE("a free body beside asynchronous cloth gains exactly the work of its loads") {
  Scene scene = small_box_on_sheet();
  scene.attachments.clear();
  Simulation sim(scene, Asynchronous(), 1);
  const Pushed pushed = push(sim, 1e-7, 1e-4);
  CHECK(pushed.energy == Approx(pushed.work).epsilon(1e-9));
  CHECK(pushed.balance < 1e-9);
}

TEST_CASE("bodies under torques have the same bits on any number of threads and when resumed") {
  Scene scene = small_box_on_sheet();
  scene.rigid_rebuild_interval = 20;
  const auto pushed = [&](int threads) {
    auto sim = std::make_unique<Simulation>(scene, Asynchronous(), threads);
    sim->set_external_body_torques(Vec3(0, 1e-4, 0).transpose());
    return sim;
  };
  const auto one = pushed(1), three = pushed(3);
  for (int i = 0; i < 20; ++i) one->step(), three->step();
  CHECK(same(one->checkpoint(), three->checkpoint()));
  const auto resumed = pushed(2);
  resumed->restore(one->checkpoint());
  for (int i = 0; i < 20; ++i) one->step(), resumed->step();
  CHECK(same(one->checkpoint(), resumed->checkpoint()));
}
