// Tests of the energy account: energies, work and losses balance.
#include <catch2/catch.hpp>
#include <utility>

#include "core/magnetics/sources/sphere.h"
#include "core/mesh/generators.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// A sheet that is pinned along one edge.
Scene sheet() {
  Scene scene;
  Cloth cloth;
  cloth.mesh = share(grid_cells(0.2, 0.2, 8, 8));
  const Points& x = cloth.mesh->vertices();
  for (Index i = 0; i < x.rows(); ++i)
    if (x(i, 0) == x.col(0).minCoeff()) cloth.pins.push_back(i);
  scene.cloths.push_back(cloth);
  return scene;
}

// Returns `scene` with a script that moves the pinned edge by `motion` [m] in 0.2 s, then back.
Scene drawn(Scene scene, const Vec3& motion) {
  Cloth& cloth = scene.cloths[0];
  const Index n = static_cast<Index>(cloth.pins.size());
  cloth.script_times = {0.0, 0.2, 0.4};
  cloth.script_positions.resize(3 * n, 3);
  for (const Index time : {0, 1, 2})
    for (Index i = 0; i < n; ++i)
      cloth.script_positions.row(time * n + i) =
          cloth.mesh->vertices().row(cloth.pins[i]) + (time == 1 ? 1.0 : 0.0) * motion.transpose();
  return scene;
}

// A cube with edges of 0.1 m and a mass of 1 kg.
RigidBody cube(const Vec3& position) {
  RigidBody body;
  body.name = "cube";
  body.mesh = share(box(0.1, 0.1, 0.1));
  body.shape = BodyShape::Box;
  body.position = position;
  body.friction = 0.5;
  return body;
}

// Returns the largest absolute energy balance [1] (AccountReport::balance) within 0.4 s.
double imbalance(const Scene& scene, const IntegratorOptions& options) {
  Simulation sim(scene, options, 1);
  double most = 0.0;
  while (sim.time() < 0.4 - 1e-9) {
    sim.step();
    most = std::max(most, std::abs(sim.report().account.balance));
  }
  return most;
}

}  // namespace

TEST_CASE("without losses, energy minus work stays constant, the better the shorter the steps") {
  const auto midpoint = [](double h) {
    IntegratorOptions options = step_of(h, "nonlinear-midpoint");
    options.implicit()->jacobian = JacobianKind::Exact;
    return options;
  };
  // In the first scene, the pinned edge does not move. In the second, it moves in the plane of the
  // sheet, and in the third perpendicular to this plane.
  for (const Scene& scene :
       {sheet(), drawn(sheet(), Vec3(-0.03, 0, 0)), drawn(sheet(), Vec3(0, 0, 0.1))}) {
    const double coarse = imbalance(scene, midpoint(2e-3)), fine = imbalance(scene, midpoint(5e-4));
    CAPTURE(coarse, fine);
    // If the edge moves, the jumps of its velocity reduce the scheme to first order. With a quarter
    // of the step, the imbalance must therefore fall to a quarter or less.
    CHECK(fine < 0.03);
    CHECK(fine < coarse / 4.0);
  }
}

TEST_CASE("asynchronous steps account for the work of pins at every event") {
  for (const Vec3& motion : {Vec3(-0.03, 0, 0), Vec3(0, 0, 0.1), Vec3(0, 0.03, 0)})
    CHECK(imbalance(drawn(sheet(), motion), Asynchronous()) < 0.005);
}

TEST_CASE("implicit Euler loses energy in the account, and never gains any") {
  for (const Scene& scene : {sheet(), drawn(sheet(), Vec3(0, 0, 0.1))}) {
    Simulation sim(scene, step_of(4e-3), 1);
    for (int i = 0; i < 100; ++i) {
      sim.step();
      CHECK(sim.report().account.balance < 0.01);
    }
    CHECK(sim.report().account.lost > 0.0);
  }
}

TEST_CASE("the linearised midpoint rule and BDF-2 swing stiff sheets without a gain of energy") {
  for (const char* method : {"implicit-midpoint", "bdf2"})
    for (const double stiffness : {1e3, 1e5}) {
      Scene scene = sheet();
      ClothMaterial& material = scene.cloths[0].material;
      material.weft_stiffness = material.warp_stiffness = stiffness;
      material.shear_stiffness = 0.25 * stiffness, material.density = 0.03;
      Simulation sim(scene, integrator_named(method), 1);
      double most = -1.0;
      while (sim.time() < 0.3) {
        sim.step();
        most = std::max(most, sim.report().account.balance);
      }
      CAPTURE(method, stiffness);
      // If the energy of neglected strain were allowed to be 0.2 of the kinetic energy, as with
      // implicit Euler, the gain would be 0.15 with BDF-2 and 0.12 with the midpoint rule.
      CHECK(most < 0.01);
    }
}

TEST_CASE("a sheet that moves by rounding errors only has no balance of energy") {
  for (const char* method : {"asynchronous", "semi-implicit-euler", "nonlinear-midpoint"}) {
    Scene scene = sheet();
    scene.gravity.setZero();
    Cloth& cloth = scene.cloths[0];
    cloth.pins.clear();
    // The rotation causes rounding errors in the edges of the mesh.
    const Eigen::AngleAxisd rotation(0.7, Vec3(1.0, 2.0, 3.0).normalized());
    cloth.mesh = share(cloth.mesh->moved(Vec3(0.1, 0.2, 0.3), rotation.toRotationMatrix()));
    Simulation sim(scene, integrator_named(method), 1);
    for (int i = 0; i < 20; ++i) sim.step();
    CAPTURE(method);
    CHECK(sim.report().energy.kinetic > 0.0);
    CHECK(sim.report().account.balance == 0.0);
    CHECK(sim.report().account.contact_balance == 0.0);
  }
}

TEST_CASE("the work of external forces is what the sheet gains") {
  Scene scene = sheet();
  scene.cloths[0].pins.clear();
  scene.gravity.setZero();
  Simulation sim(scene, step_of(2e-3, "implicit-midpoint"), 1);
  Points forces = Points::Zero(sim.positions().rows(), 3);
  forces.col(0).setConstant(1e-4);
  sim.set_external_forces(forces);
  for (int i = 0; i < 50; ++i) sim.step();
  const StepReport& report = sim.report();
  CHECK(report.energy.kinetic > 0.0);
  CHECK(report.account.loads ==
        Approx(report.energy.kinetic + report.energy.membrane).epsilon(1e-6));
}

TEST_CASE("a floor that carries a sheet along works on it through friction") {
  Scene scene = sheet();
  scene.cloths[0].pins.clear();
  scene.cloths[0].friction = 0.5;
  Obstacle floor;
  floor.mesh = share(floor_square(2.0, 4).moved(Vec3(0, 0, -3e-3)));
  floor.friction = 0.5;
  floor.times = {0.0, 0.4};
  floor.positions = Points::Zero(2, 3);
  floor.positions(1, 0) = 0.4;
  scene.obstacles.push_back(floor);
  Simulation sim(scene, step_of(1e-3), 1);
  while (sim.time() < 0.38) sim.step();
  const StepReport& report = sim.report();
  // The sheet starts at rest and ends at the 1 m/s of the floor. Sliding dissipates as much energy
  // as the sheet gains.
  CHECK(report.energy.kinetic == Approx(0.5 * 0.04 * 0.3).epsilon(0.02));
  CHECK(report.account.scripts == Approx(2.0 * report.energy.kinetic).epsilon(0.1));
  CHECK(report.account.friction == Approx(report.energy.kinetic).epsilon(0.1));
  CHECK(std::abs(report.account.balance) < 1.3);
}

TEST_CASE("what a damped sheet loses is its work against viscosity and damping of bending") {
  for (const bool bending : {false, true}) {
    Scene scene = sheet();
    ClothMaterial& material = scene.cloths[0].material;
    if (bending)
      material.bending_damping = 0.02, material.bending_weft = material.bending_warp = 1e-3;
    else
      material.viscosity_shear = 0.5, material.viscosity_dilation = 0.2;
    IntegratorOptions options = step_of(2.5e-4, "nonlinear-midpoint");
    options.implicit()->jacobian = JacobianKind::Exact;
    Simulation sim(scene, options, 1);
    const auto energy = [&] {
      const EnergyReport& e = sim.report().energy;
      return e.kinetic + e.membrane + e.bending + e.gravity;
    };
    const double start = energy();
    for (int i = 0; i < 1200; ++i) sim.step();
    const double lost = start - energy();
    CAPTURE(bending, sim.report().account.lost);
    CHECK(lost > 0.01 * sim.report().account.largest_kinetic);
    // The tolerance covers the energy error of the scheme.
    CHECK(sim.report().account.damping == Approx(lost).epsilon(0.03));
  }
}

TEST_CASE("strain limits account for the energy that their sweeps take") {
  // A sheet that is stretched by 20 % along weft, twice its limit, and left to itself.
  Scene scene = sheet();
  Cloth& cloth = scene.cloths[0];
  cloth.pins.clear();
  Points x = cloth.mesh->vertices();
  x.col(0) *= 1.2;
  cloth.mesh = share(TriangleMesh(x, cloth.mesh->triangles(), cloth.mesh->uv()));
  cloth.strain_limit = StrainLimit{};
  cloth.strain_limit->weft = 0.1;
  scene.gravity.setZero();
  scene.collisions = false;
  scene.limits.strain_rate = 0.0;
  // Takes one step. Returns the energy at its end, and its report.
  const auto step = [&] {
    Simulation sim(scene, step_of(1e-4, "symplectic-euler"), 1);
    sim.step();
    const StepReport& report = sim.report();
    return std::pair(report.energy.kinetic + report.energy.membrane + report.energy.bending,
                     report);
  };
  const auto [end, report] = step();
  cloth.strain_limit.reset();
  const double without_sweeps = step().first;
  REQUIRE(report.limits.sweeps > 0);
  CHECK(report.account.limits > 0.01 * without_sweeps);
  // The tolerances cover rounding errors of the energies.
  CHECK(report.account.limits == Approx(without_sweeps - end).epsilon(1e-9));
  CHECK(std::abs(report.account.withheld) < 1e-9 * without_sweeps);
}

TEST_CASE("pins that lift a sheet at its strain limit do the work that its weight needs") {
  // The weight stretches the sheet by a tenth without limits, and by a fiftieth with them.
  Scene scene = sheet();
  Cloth& cloth = scene.cloths[0];
  cloth.material.weft_stiffness = cloth.material.warp_stiffness = 3.0;
  cloth.material.shear_stiffness = 1.0;
  cloth.strain_limit = StrainLimit{};
  cloth.strain_limit->weft = 0.02;
  scene.gravity = Vec3(9.81, 0, 0);
  scene.collisions = false;
  const Index n = static_cast<Index>(cloth.pins.size());
  constexpr int n_times = 51;
  cloth.script_positions.resize(n_times * n, 3);
  for (int time = 0; time < n_times; ++time) {
    const double share = static_cast<double>(time) / (n_times - 1);
    cloth.script_times.push_back(0.5 + 0.5 * share);
    for (Index i = 0; i < n; ++i)
      cloth.script_positions.row(time * n + i) =
          cloth.mesh->vertices().row(cloth.pins[i]) -
          0.2 * share * share * (3.0 - 2.0 * share) * Eigen::RowVector3d::UnitX();
  }
  const auto kept = [](const StepReport& r) {
    return r.energy.kinetic + r.energy.membrane + r.energy.bending + r.energy.gravity;
  };
  struct Case {
    const char* method;
    // The larger tolerances cover vibrations, which midpoint and BDF-2 damp little or not at all.
    double step, tolerance;
  };
  for (const Case& c : {Case{"semi-implicit-euler", 4e-3, 0.01}, Case{"backward-euler", 4e-3, 0.01},
                        Case{"implicit-midpoint", 1e-3, 0.1}, Case{"bdf2", 1e-3, 0.2}}) {
    Simulation sim(scene, step_of(c.step, c.method), 1);
    while (sim.time() < 0.5 - 1e-9) sim.step();
    const double before = kept(sim.report()), scripts = sim.report().account.scripts;
    while (sim.time() < 1.1) sim.step();
    const StepReport& report = sim.report();
    CAPTURE(c.method, report.limits.weft_excess, report.account.limits);
    CHECK(report.account.scripts - scripts == Approx(kept(report) - before).epsilon(c.tolerance));
  }
}

TEST_CASE("certification accounts for the energy of a sheet that it stops") {
  Scene scene = sheet();
  Cloth& cloth = scene.cloths[0];
  cloth.pins.clear();
  scene.gravity.setZero();
  cloth.velocities = Points::Zero(cloth.mesh->vertices().rows(), 3);
  cloth.velocities.col(2).setConstant(-1.0);
  Obstacle floor;
  floor.mesh = share(floor_square(2.0, 4).moved(Vec3(0, 0, -5.5e-3)));
  scene.obstacles.push_back(floor);
  // With an explicit scheme, impulses stop the sheet. The energy that they dissipate is part of
  // account.withheld.
  Simulation sim(scene, step_of(1e-3, "symplectic-euler"), 1);
  const double start = sim.report().energy.kinetic;
  while (sim.time() < 8e-3) sim.step();
  const EnergyReport& e = sim.report().energy;
  const double lost = start - e.kinetic - e.membrane - e.bending;
  CHECK(lost > 0.9 * start);
  CHECK(sim.report().account.withheld == Approx(lost).epsilon(0.02));
}

TEST_CASE("a floor that carries a box along works on it through friction") {
  Scene scene;
  scene.bodies.push_back(cube(Vec3(0, 0, 0.05)));
  Obstacle floor;
  floor.mesh = share(box(4.0, 4.0, 0.2).moved(Vec3(0, 0, -0.1)));
  floor.friction = 0.5;
  floor.times = {0.0, 1.0};
  floor.positions = Points::Zero(2, 3);
  floor.positions(1, 0) = 1.0;
  scene.obstacles.push_back(floor);
  Simulation sim(scene, step_of(1e-3), 1);
  while (sim.time() < 0.9) sim.step();
  const StepReport& report = sim.report();
  // The box starts at rest and ends at 1 m/s. Sliding dissipates as much energy as the box gains.
  CHECK(report.energy.body_kinetic == Approx(0.5).epsilon(1e-3));
  CHECK(report.account.scripts == Approx(1.0).epsilon(0.01));
  CHECK(report.account.lost == Approx(0.5).epsilon(0.02));
}

TEST_CASE("a floor that rises works against the weight of a box") {
  Scene scene;
  scene.bodies.push_back(cube(Vec3(0, 0, 0.05)));
  Obstacle floor;
  floor.mesh = share(box(4.0, 4.0, 0.2).moved(Vec3(0, 0, -0.1)));
  floor.times = {0.0, 0.2, 1.2};
  floor.positions = Points::Zero(3, 3);
  floor.positions(2, 2) = 0.1;
  scene.obstacles.push_back(floor);
  Simulation sim(scene, step_of(1e-3), 1);
  while (sim.time() < 1.1) sim.step();
  // The floor starts suddenly at v = 0.1 m/s, which requires the work m v^2 = 0.01 J. Half of this
  // work becomes kinetic energy, and half is lost. The other term is the work against the weight
  // over 0.09 m.
  CHECK(sim.report().account.scripts == Approx(9.81 * 0.09 + 0.01).epsilon(0.02));
}

TEST_CASE("a magnet on a scripted obstacle works on the magnet of a body") {
  const auto imbalance = [](double h) {
    Scene scene;
    scene.gravity.setZero();
    scene.bodies.push_back(cube(Vec3::Zero()));
    Obstacle carrier;
    carrier.name = "carrier";
    carrier.mesh = share(box(0.02, 0.02, 0.02).moved(Vec3(0, 0, 0.4)));
    carrier.times = {0.0, 1.0};
    carrier.positions = Points::Zero(2, 3);
    carrier.positions(1, 2) = -0.2;
    scene.obstacles.push_back(carrier);
    for (const bool on_body : {true, false}) {
      Magnet magnet;
      magnet.body = on_body ? "cube" : "carrier";
      const Vec3 place(0, 0, on_body ? 0.0 : 0.4);
      magnet.source = MagneticBody{std::make_shared<Sphere>(0.02, 1.2 * Vec3::UnitZ()),
                                   {place, Vec4(1, 0, 0, 0)}};
      scene.magnets.push_back(magnet);
    }
    Simulation sim(scene, step_of(h), 1);
    while (sim.time() < 0.5 - 1e-9) sim.step();
    REQUIRE(sim.report().energy.body_kinetic > 1e-4);
    REQUIRE(std::abs(sim.report().account.scripts) > 0.1 * sim.report().energy.body_kinetic);
    return std::abs(sim.report().account.balance);
  };
  const double coarse = imbalance(4e-3), fine = imbalance(1e-3);
  CAPTURE(coarse, fine);
  CHECK(fine < 1e-4);
  CHECK(fine < 0.2 * coarse);  // kick-drift-kick is of second order
}

TEST_CASE("a cloth that starts inside its thickness gains only the energy of its contacts") {
  Scene scene = sheet();
  scene.cloths[0].pins.clear();
  scene.cloths[0].thickness = 4e-3;
  Obstacle floor;
  floor.mesh = share(floor_square(2.0, 4).moved(Vec3(0, 0, -1e-3)));
  scene.obstacles.push_back(floor);
  Simulation sim(scene, step_of(1e-3), 1);
  const double contact = sim.report().energy.contact;
  CHECK(contact > 0.0);
  double without = 0.0, with_contacts = 0.0;
  for (int i = 0; i < 20; ++i) {
    sim.step();
    const AccountReport& account = sim.report().account;
    without = std::max(without, account.balance * account.largest_kinetic);
    with_contacts = std::max(with_contacts, account.contact_balance * account.largest_kinetic);
  }
  CHECK(without > 0.03 * contact);
  CHECK(with_contacts < 1e-9 * contact);
}

TEST_CASE("an account restarts at zero when the user writes velocities") {
  Simulation sim(sheet(), step_of(2e-3), 1);
  for (int i = 0; i < 20; ++i) sim.step();
  const double lost = sim.report().account.lost;
  CHECK(lost > 0.0);
  Points velocities = sim.velocities();
  velocities.col(2).array() += 5.0;
  sim.set_velocities(velocities);
  sim.step();
  CHECK(sim.report().account.balance < 0.01);
}
