// Tests of the motion of bodies under magnetic forces, without the rest of a simulation.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/base/error.h"
#include "core/electrodynamics/magnetic_motion.h"
#include "core/magnetics/sources/axisymmetric.h"
#include "core/magnetics/sources/polyhedron.h"
#include "core/magnetics/sources/sphere.h"
#include "core/mesh/generators.h"

using namespace loomstone;

namespace {

constexpr double step = 1e-3;

// Bodies and stands (static obstacles) with their magnets and coils. Gravity is zero by default.
struct Experiment {
  std::vector<RigidBody> bodies;
  MagneticScene scene;
  std::vector<RigidObstacle> obstacles;

  void add(const std::string& name, const Vec3& position, const Vec3& spin = Vec3::Zero()) {
    RigidBody body;
    body.name = name;
    body.mesh = std::make_shared<const TriangleMesh>(box(0.02, 0.01, 0.015));
    body.shape = BodyShape::Box, body.density = 7500.0;
    body.position = position, body.angular_velocity = spin;
    bodies.push_back(body);
  }
  void add_stand(const std::string& name) {
    scene.carriers.push_back(
        {name, std::make_shared<const TriangleMesh>(box(0.01, 0.01, 0.01)), {}, {}, false});
    obstacles.push_back({scene.carriers.back().mesh, 0.3, Vec3::Zero(), Vec4(1, 0, 0, 0), {}});
  }
  void add_cuboid(const std::string& body, const Vec3& polarization) {
    Magnet magnet;
    magnet.body = body;
    magnet.source =
        MagneticBody{std::make_shared<Cuboid>(Vec3(0.02, 0.01, 0.015), polarization), {}};
    scene.magnets.push_back(magnet);
  }
};

// An experiment in motion: its models and its state.
struct Motion {
  RigidWorld world;
  RigidState state;
  MagneticModel model;
  MagneticState magnetic;
  std::unique_ptr<MagneticMotion> stage;
  ObstaclePlaces places;
  int steps = 0;

  explicit Motion(Experiment made)
      : world(made.bodies, made.obstacles, Vec3::Zero(), false), state(world.initial_state()) {
    std::vector<MagneticCarrier> carriers;
    for (std::size_t b = 0; b < made.bodies.size(); ++b)
      carriers.push_back({made.bodies[b].name, made.bodies[b].mesh, world.mass_properties()[b],
                          made.bodies[b].orientation, false});
    made.scene.carriers.insert(made.scene.carriers.begin(), carriers.begin(), carriers.end());
    made.scene.n_bodies = static_cast<Index>(carriers.size());
    places.poses.assign(made.obstacles.size(), RigidPose{});
    model = build_magnetic_model(made.scene);
    magnetic.circuits.currents = Vector::Zero(static_cast<Eigen::Index>(made.scene.coils.size()));
    renew();
  }
  void renew() { stage = std::make_unique<MagneticMotion>(model); }
  void advance(int n) {
    const Points zeros = Points::Zero(model.n_bodies(), 3);
    const BodyImpulses none{zeros, zeros};
    for (int i = 0; i < n; ++i)
      stage->advance({}, {step * steps++, step, none, none, places, places}, world, state,
                     magnetic);
  }
  CarrierPlaces here() const { return {state, places.poses}; }

  double mass(Index b) const { return model.bodies[b].mass.mass; }
  Vec3 momentum() const {
    Vec3 sum = Vec3::Zero();
    for (Index b = 0; b < model.n_bodies(); ++b)
      sum += mass(b) * state.velocities.row(b).transpose();
    return sum;
  }
  Vec3 angular_momentum() const {  // about the origin
    Vec3 sum = Vec3::Zero();
    for (Index b = 0; b < model.n_bodies(); ++b) {
      const Vec3 x = state.positions.row(b), v = state.velocities.row(b),
                 spin = state.angular_velocities.row(b);
      sum += x.cross(mass(b) * v) +
             world_inertia(model.bodies[b].mass, state.orientations.row(b).transpose()) * spin;
    }
    return sum;
  }
  double kinetic_energy() const {
    double sum = 0.0;
    for (Index b = 0; b < model.n_bodies(); ++b) {
      const Vec3 spin = state.angular_velocities.row(b);
      const Mat3 inertia =
          world_inertia(model.bodies[b].mass, state.orientations.row(b).transpose());
      sum += 0.5 * (mass(b) * state.velocities.row(b).squaredNorm() + spin.dot(inertia * spin));
    }
    return sum;
  }
  double magnetic_energy() const { return stage->energy({}, here(), magnetic.moments); }
};

Experiment two_magnets() {
  Experiment made;
  made.add("a", Vec3(0, 0, 0), Vec3(3, -2, 1));
  made.add("b", Vec3(0.05, 0.02, 0.03));
  made.add_cuboid("a", Vec3(0.3, 0.2, 1.0));
  made.add_cuboid("b", Vec3(-0.5, 0.8, 0.1));
  return made;
}

// A magnet above a stationary coil, on the axis of the coil. The magnet does not rotate, so the
// drifts between kicks conserve its kinetic energy to rounding.
Experiment magnet_over_coil(const Coil& coil) {
  Experiment made;
  made.add("magnet", Vec3(0, 0, 0.03));
  made.add_cuboid("magnet", Vec3(0, 0, 1.0));
  made.add_stand("stand");
  made.scene.coils.push_back(coil);
  return made;
}

Coil winding() {
  Coil coil;
  coil.body = "stand";
  coil.source = MagneticBody{std::make_shared<Solenoid>(0.02, 0.01, 100.0, 1.0), {}};
  return coil;
}

}  // namespace

TEST_CASE("two free magnets keep linear and angular momentum to rounding") {
  Motion motion(two_magnets());
  const Vec3 p = motion.momentum(), l = motion.angular_momentum();
  motion.advance(40);
  const double size = motion.mass(0) * motion.state.velocities.row(0).norm();  // exchanged momentum
  REQUIRE(size > 1e-4);
  CHECK((motion.momentum() - p).norm() < 1e-12 * size);
  CHECK((motion.angular_momentum() - l).norm() < 1e-12 * size * 0.05);  // lever arms of 5 cm
}

TEST_CASE("two free magnets keep their energy with second order of the sub-step") {
  double errors[2];
  for (int i = 0; i < 2; ++i) {
    Experiment made = two_magnets();
    made.scene.tolerance = 1e-8;  // keeps errors of the forces below those of the sub-steps
    made.scene.substep = i == 0 ? 0.04 : 0.02;
    Motion motion(made);
    const double start = motion.kinetic_energy() + motion.magnetic_energy();
    motion.advance(40);
    errors[i] = std::abs(motion.kinetic_energy() + motion.magnetic_energy() - start);
  }
  CHECK(errors[0] > 3.0 * errors[1]);  // the factor is 4 to leading order
}

namespace {

// A pair of magnets that touch and turn about their common centre at 20 rad/s.
Experiment touching_pair(bool round, double friction) {
  Experiment made;
  const Vec3 omega(0, 0, 20.0);
  for (const double side : {-1.0, 1.0}) {
    const double half = round ? 0.005 : 0.01;
    const std::string name = side < 0.0 ? "a" : "b";
    made.add(name, Vec3(side * half, 0, 0), omega);
    RigidBody& body = made.bodies.back();
    body.friction = friction, body.velocity = omega.cross(body.position);
    if (!round) {
      made.add_cuboid(name, Vec3(1.0, 0, 0));
      continue;
    }
    body.mesh = std::make_shared<const TriangleMesh>(icosphere(half, 3));
    body.shape = BodyShape::Sphere;
    Magnet magnet;
    magnet.body = name;
    magnet.source = MagneticBody{std::make_shared<Sphere>(half, Vec3(1.0, 0, 0)), {}};
    made.scene.magnets.push_back(magnet);
  }
  return made;
}

}  // namespace

TEST_CASE("magnets that touch and turn about their centre keep their momenta and their energy") {
  const bool round = GENERATE(true, false);
  const double friction = GENERATE(0.0, 0.3);
  CAPTURE(round, friction);
  Motion motion(touching_pair(round, friction));
  const Vec3 l = motion.angular_momentum();
  const double energy = motion.kinetic_energy(),
               size = motion.mass(0) * motion.state.velocities.row(0).norm();
  double most = 0.0;
  for (int i = 0; i < 100; ++i) {
    motion.advance(1);
    most = std::max(most, motion.kinetic_energy());
  }
  CHECK(motion.momentum().norm() < 1e-12 * size);
  CHECK((motion.angular_momentum() - l).norm() < 1e-12 * l.norm());
  // The bound on the kinetic energy is larger for cuboids. The forces between them change strongly
  // as soon as the touching faces are not parallel, so these faces rock. Without friction, they
  // also slide.
  CHECK(most < (round ? 1.00001 : friction > 0.0 ? 1.01 : 1.1) * energy);
  CHECK(motion.kinetic_energy() > 0.999 * energy);
  const Vec3 apart = (motion.state.positions.row(1) - motion.state.positions.row(0)).transpose();
  CHECK(apart.norm() == Approx(round ? 0.01 : 0.02).epsilon(1e-3));
}

TEST_CASE("a magnet that touches a body it magnetises keeps their momenta as they turn") {
  Experiment made = touching_pair(true, 0.0);
  made.scene.magnets[1].source = SoftBody{soft_sphere(0.005, 1000.0, 0), {}};
  Motion motion(made);
  const Vec3 l = motion.angular_momentum();
  motion.advance(100);
  CHECK((motion.angular_momentum() - l).norm() < 1e-12 * l.norm());
}

TEST_CASE("bodies that touch and spin in place do not start to turn about each other") {
  Experiment made = touching_pair(true, 0.0);
  made.scene.field = Vec3(0.5, 0, 0);
  for (Magnet& magnet : made.scene.magnets)
    magnet.source = SoftBody{soft_sphere(0.005, 1000.0, 0), {}};
  for (RigidBody& body : made.bodies) body.velocity.setZero(), body.angular_velocity *= 10.0;
  Motion motion(made);
  motion.advance(100);
  CHECK(motion.state.velocities.norm() < 1e-6);
  CHECK(motion.state.angular_velocities(0, 2) == Approx(200.0));
}

TEST_CASE("magnets that touch go on turning on a smooth floor") {
  Experiment made = touching_pair(true, 0.0);
  made.scene.gravity = Vec3(0, 0, -9.81);
  made.scene.carriers.push_back(
      {"floor", std::make_shared<const TriangleMesh>(floor_square(0.2, 1)), {}, {}, false});
  made.obstacles.push_back(
      {made.scene.carriers.back().mesh, 0.0, Vec3(0, 0, -0.005), Vec4(1, 0, 0, 0), {}});
  Motion motion(made);
  motion.places.poses[0].position = Vec3(0, 0, -0.005);
  const Vec3 l = motion.angular_momentum();
  motion.advance(100);
  CHECK(motion.angular_momentum().z() == Approx(l.z()).epsilon(0.01));
  CHECK(motion.state.positions.col(2).cwiseAbs().maxCoeff() < 1e-5);
}

TEST_CASE("free magnets and touching ones keep their common momenta") {
  Experiment made = touching_pair(true, 0.3);
  made.add("c", Vec3(0.03, 0.02, 0.01), Vec3(3, -2, 1));
  made.add_cuboid("c", Vec3(0.3, 0.2, 1.0));
  Motion motion(made);
  const Vec3 p = motion.momentum(), l = motion.angular_momentum();
  motion.advance(40);
  const double size = motion.mass(2) * motion.state.velocities.row(2).norm();  // exchanged momentum
  REQUIRE(size > 1e-4);
  CHECK((motion.momentum() - p).norm() < 1e-12 * size);
  CHECK((motion.angular_momentum() - l).norm() < 1e-12 * size * 0.03);  // lever arms of 3 cm
}

TEST_CASE("magnets that snap together gain less than two hundredths of their kinetic energy") {
  // With this large `substep`, the error of the work (work_error.h) must limit the sub-steps.
  Experiment made;
  made.add("a", Vec3(0, 0, 0));
  made.add("b", Vec3(0, 0, 0.03));
  made.add_cuboid("a", Vec3(0, 0, 1.0));
  made.add_cuboid("b", Vec3(0, 0, 1.0));
  made.scene.substep = 1.0;
  Motion motion(made);
  const double start = motion.magnetic_energy();
  double gain = 0.0, kinetic = 0.0;
  for (int i = 0; i < 100; ++i) {
    motion.advance(1);
    kinetic = std::max(kinetic, motion.kinetic_energy());
    gain = std::max(gain, motion.kinetic_energy() + motion.magnetic_energy() - start);
  }
  const double apart =
      motion.state.positions(1, 2) - motion.state.positions(0, 2) - 0.015;  // the bodies' height
  CHECK(std::abs(apart) < 1e-4);
  CHECK(kinetic > 0.1);
  CHECK(gain < 0.02 * kinetic);
}

TEST_CASE("a stage rebuilt between two steps changes no bit") {
  Coil coil = winding();
  coil.resistance = 0.5, coil.inductance = 1e-3, coil.voltages = {2.0};
  Motion kept(magnet_over_coil(coil)), renewed(magnet_over_coil(coil));
  for (int i = 0; i < 5; ++i) {
    kept.advance(2), renewed.advance(2);
    renewed.renew();
  }
  CHECK(kept.state.positions == renewed.state.positions);
  CHECK(kept.state.orientations == renewed.state.orientations);
  CHECK(kept.state.velocities == renewed.state.velocities);
  CHECK(kept.magnetic.circuits.currents == renewed.magnetic.circuits.currents);
}

TEST_CASE("the energy from a circuit's source is heat, stored energy and work on bodies") {
  Coil coil = winding();
  // With the second inductance, the current settles in far less than the duration of a kick, which
  // is half a sub-step.
  coil.resistance = 0.5, coil.inductance = GENERATE(1e-3, 1e-6), coil.voltages = {2.0};
  Motion motion(magnet_over_coil(coil));
  motion.advance(20);
  const CircuitState& circuits = motion.magnetic.circuits;
  const double work = motion.kinetic_energy();
  REQUIRE(work > 1e-6 * circuits.supply);
  // Each kick satisfies the balance exactly; the tolerance covers rounding in sums over many kicks.
  CHECK(std::abs(circuits.supply - circuits.heat - circuits.energy - work) <
        1e-12 * circuits.supply);
}

TEST_CASE("currents approach V / R, however short the time constant of their circuit is") {
  Coil coil = winding();
  coil.resistance = 10.0, coil.voltages = {2.0};
  // V / R is 0.2 A. The magnet moves by less than a millimetre, so it induces little voltage.
  for (const double inductance : {1e-2, 1e-3, 1e-4, 1e-6, 1e-9}) {
    coil.inductance = inductance;
    Motion motion(magnet_over_coil(coil));
    double before = 0.0;
    for (int i = 1; i <= 10; ++i) {
      motion.advance(1);
      const double now = motion.magnetic.circuits.currents[0];
      const double exact = 0.2 * -std::expm1(-coil.resistance / inductance * step * motion.steps);
      CAPTURE(inductance, i, now, exact);
      CHECK(now >= before - 1e-3 * 0.2);  // no oscillation
      CHECK(std::abs(now - exact) < 0.04 * 0.2);
      before = now;
    }
  }
}

TEST_CASE("the source of a given current does the work on the bodies that it moves") {
  Coil coil = winding();
  coil.currents = {3.0};
  Motion motion(magnet_over_coil(coil));
  motion.advance(20);
  const double supply = motion.magnetic.circuits.supply;
  REQUIRE(supply > 0.0);
  CHECK(std::abs(motion.kinetic_energy() - supply) < 1e-12 * supply);
}

TEST_CASE("a magnet must name what carries it") {
  MagneticScene scene;
  scene.carriers.push_back({"a", std::make_shared<const TriangleMesh>(box(1, 1, 1)), {}, {}, true});
  Magnet magnet;
  magnet.source = MagneticBody{std::make_shared<Sphere>(0.1, Vec3(0, 0, 1)), {}};
  for (const char* body : {"", "b"}) {
    magnet.body = body;
    scene.magnets = {magnet};
    CHECK_THROWS_AS(build_magnetic_model(scene), InvalidInput);
  }
  scene.magnets[0].body = "a";  // a carrier that deforms
  CHECK_THROWS_AS(build_magnetic_model(scene), Unsupported);
}
