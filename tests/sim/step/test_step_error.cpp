// Tests of steps with error control: impacts do not increase the energy, stiff sheets swing as
// fast as soft ones, and frames lie on the paths that certification has checked.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/collision/tangle/intersections.h"
#include "core/mesh/generators.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

ClothMaterial isotropic(double stiffness, double density) {
  ClothMaterial material;
  material.weft_stiffness = material.warp_stiffness = stiffness;
  material.shear_stiffness = 0.5 * stiffness;
  material.density = density;
  return material;
}

// A towel, tilted by 60 degrees, that falls onto a floor at `speed` [m/s].
Scene towel(double speed) {
  Scene scene;
  Cloth cloth;
  cloth.name = "towel";
  TriangleMesh flat = grid_cells(0.18, 0.12, 22, 15);
  Points x = flat.vertices();
  const double angle = std::acos(0.5);
  for (Index i = 0; i < x.rows(); ++i) {
    const double along = x(i, 0) + 0.09;
    x.row(i) << along * std::cos(angle), x(i, 1), 0.005 + along * std::sin(angle);
  }
  cloth.mesh = share(TriangleMesh(x, flat.triangles(), flat.uv()));
  cloth.material = isotropic(300.0, 0.3);
  cloth.velocities = Points::Zero(x.rows(), 3);
  cloth.velocities.col(2).setConstant(-speed);
  scene.cloths.push_back(cloth);
  Obstacle floor;
  floor.name = "floor";
  floor.mesh = share(floor_square(2.0, 4));
  scene.obstacles.push_back(floor);
  return scene;
}

IntegratorOptions step_with(double h, std::optional<double> accuracy) {
  IntegratorOptions options = step_of(h);
  options.implicit()->accuracy = accuracy;
  return options;
}

struct Fall {
  double stretch = 1.0;  // largest stretch over all steps
  // Largest increase of the energy, excluding that of contacts, divided by the largest kinetic
  // energy.
  double gain = 0.0;
  double contact_gain = 0.0;  // like `gain`, but the energy includes that of contacts
  int parts = 0;
};

Fall fall(const Scene& scene, const IntegratorOptions& options, double duration) {
  Simulation sim(scene, options, 1);
  const auto total = [&] {
    const EnergyReport& e = sim.report().energy;
    return e.kinetic + e.membrane + e.bending + e.gravity;
  };
  const double start = total();
  const double start_of_contacts = sim.report().energy.contact;
  double most = start, most_with = start, kinetic = sim.report().energy.kinetic;
  Fall found;
  while (sim.time() < duration - 1e-9) {
    sim.step();
    found.stretch = std::max(found.stretch, sim.report().strain.stretch);
    found.parts += sim.report().parts;
    most = std::max(most, total());
    most_with = std::max(most_with, total() + sim.report().energy.contact - start_of_contacts);
    kinetic = std::max(kinetic, sim.report().energy.kinetic);
  }
  found.gain = (most - start) / kinetic;
  found.contact_gain = (most_with - start) / kinetic;
  return found;
}

enum class Pinned { Corners, Edge };

// Returns the time [s] that a flat sheet pinned at two corners, or along an edge, takes to swing
// down until its free edge is vertically below the pins. The time is interpolated linearly between
// two steps. It is infinite if the sheet takes more than 1.5 s.
double time_to_bottom(double stiffness, double density, const IntegratorOptions& options,
                      Pinned pinned = Pinned::Corners) {
  const Index cells = 12;
  Scene scene;
  Cloth cloth;
  cloth.mesh = share(grid_cells(0.3, 0.3, cells, cells));
  cloth.material = isotropic(stiffness, density);
  const Points& x = cloth.mesh->vertices();
  const double low = x.col(1).minCoeff(), high = x.col(1).maxCoeff();
  std::vector<Index> free_edge;
  for (Index i = 0; i < x.rows(); ++i) {
    const bool side = x(i, 0) == x.col(0).minCoeff() || x(i, 0) == x.col(0).maxCoeff();
    if (x(i, 1) == low && (side || pinned == Pinned::Edge)) cloth.pins.push_back(i);
    if (x(i, 1) == high) free_edge.push_back(i);
  }
  REQUIRE(cloth.pins.size() == (pinned == Pinned::Edge ? 13 : 2));
  scene.cloths.push_back(cloth);
  Simulation sim(scene, options, 1);
  double before = high;
  while (sim.time() < 1.5) {
    const double start = sim.time();
    sim.step();
    const Points now = sim.positions();
    double mean = 0.0;
    for (const Index i : free_edge) mean += now(i, 1) / static_cast<double>(free_edge.size());
    if (mean < low) return sim.time() - (sim.time() - start) * (low - mean) / (before - mean);
    before = mean;
  }
  return INFINITY;
}

}  // namespace

TEST_CASE(
    "a towel that meets a floor neither gains energy nor stretches more than in short steps") {
  for (const double speed : {4.0, 8.0}) {
    const Fall fine = fall(towel(speed), step_with(2.5e-4, 1.0), 0.08);
    for (const double h : {1e-3, 4e-3, 1e-2}) {
      const Fall coarse = fall(towel(speed), step_with(h, 1.0), 0.08);
      CAPTURE(speed, h, coarse.stretch, fine.stretch, coarse.parts);
      CHECK(coarse.stretch < 1.08 * fine.stretch);
      CHECK(coarse.gain < 0.02);
    }
    // Without a bound on the error, steps of 4 ms stretch triangles to more than 1.5 times their
    // rest lengths.
    CHECK(fall(towel(speed), step_with(4e-3, std::nullopt), 0.08).stretch > 1.5);
  }
}

TEST_CASE("a towel that meets a floor gains no energy of contacts") {
  for (const double speed : {2.0, 4.0})
    for (const double h : {1e-3, 4e-3, 1e-2}) {
      CAPTURE(speed, h);
      // The bound allows for a gain within one part. At 2 m/s, the towel moves by a third of the
      // thickness in the shortest part of a 10 ms step.
      CHECK(fall(towel(speed), step_with(h, 1.0), 0.02).contact_gain < 0.04);
    }
  // Without a bound on the error, contacts of the lower edge gain more than a fifth of the kinetic
  // energy.
  CHECK(fall(towel(2.0), step_with(2.5e-3, std::nullopt), 0.02).contact_gain > 0.2);
}

TEST_CASE("parts are shorter in proportion to the accuracy") {
  // With an accuracy of 0.2 instead of 1, parts of steps with an impact are shorter by a factor of
  // 5. Other steps are taken whole.
  CHECK(fall(towel(4.0), step_with(4e-3, 0.2), 0.08).parts >
        4 * fall(towel(4.0), step_with(4e-3, 1.0), 0.08).parts);
}

TEST_CASE(
    "the time in which a sheet swings down depends neither on its stiffness nor on the step") {
  const double exact = time_to_bottom(300.0, 0.3, step_with(5e-4, 1.0));
  for (const auto& [stiffness, density] :
       {std::pair{300.0, 0.3}, {3e3, 0.3}, {1e4, 0.3}, {1e5, 0.03}})
    for (const double h : {2e-3, 4e-3, 1e-2}) {
      CAPTURE(stiffness, h);
      CHECK(time_to_bottom(stiffness, density, step_with(h, 1.0)) == Approx(exact).epsilon(0.03));
    }
  for (const char* const method : {"implicit-midpoint", "bdf2"})
    for (const double h : {1e-3, 4e-3, 1e-2}) {
      CAPTURE(method, h);
      CHECK(time_to_bottom(1e4, 0.3, step_of(h, method)) == Approx(exact).epsilon(0.03));
      CHECK(time_to_bottom(1e5, 0.03, step_of(h, method)) == Approx(exact).epsilon(0.03));
    }
  // Without a bound on the error, a stiff sheet swings too slowly.
  CHECK(time_to_bottom(1e5, 0.03, step_with(4e-3, std::nullopt)) > 1.5 * exact);
}

TEST_CASE("a stiff sheet that swings or spins gains no energy") {
  Scene swinging, spinning;
  Cloth cloth;
  cloth.mesh = share(grid_cells(0.3, 0.3, 12, 12));
  const Points& x = cloth.mesh->vertices();
  cloth.material = isotropic(3e4, 0.2);
  spinning.cloths.push_back(cloth);
  spinning.cloths[0].velocities = Points::Zero(x.rows(), 3);
  spinning.cloths[0].velocities.col(0) = -30.0 * x.col(1);
  spinning.cloths[0].velocities.col(1) = 30.0 * x.col(0);
  for (Index i = 0; i < x.rows(); ++i)
    if (x(i, 1) == x.col(1).minCoeff()) cloth.pins.push_back(i);
  swinging.cloths.push_back(cloth);
  for (const Scene& scene : {swinging, spinning})
    for (const IntegratorOptions& options :
         {IntegratorOptions(SemiImplicitEuler()), step_with(4e-3, 1.0)})
      // The bound is the tolerated gain, 0.02 of the largest kinetic energy, plus a twentieth of
      // this gain, because a part that gains less than this twentieth is not halved.
      CHECK(fall(scene, options, 0.2).gain < 0.021);
  CHECK(fall(spinning, step_with(4e-3, std::nullopt), 0.2).gain > 0.1);
}

TEST_CASE("cloth at rest takes steps of the largest length") {
  Scene scene;
  Cloth cloth;
  cloth.mesh = share(grid_cells(0.3, 0.3, 12, 12));
  cloth.material = isotropic(3e3, 0.2);
  cloth.pins = {0, 12};
  scene.cloths.push_back(cloth);
  scene.gravity.setZero();
  Simulation sim(scene, SemiImplicitEuler(), 1);
  for (int i = 0; i < 10; ++i) sim.step();
  // Rounding errors do not count as a gain of energy, so they shorten no step.
  CHECK(sim.time() == Approx(0.1));
}

TEST_CASE("a soft sheet swings down in time in automatic steps") {
  SemiImplicitEuler automatic;
  const double exact = time_to_bottom(300.0, 0.1, step_with(2.5e-4, 1.0), Pinned::Edge);
  CHECK(time_to_bottom(300.0, 0.1, automatic, Pinned::Edge) == Approx(exact).epsilon(0.03));
}

TEST_CASE("frames inside a step that is taken in parts do not intersect") {
  Simulation sim(towel(8.0), step_with(1e-2, 1.0), 1);
  const Index n = static_cast<Index>(sim.positions().rows());
  Triangles all = sim.topology().triangles;
  const Index cloth = static_cast<Index>(all.rows());
  const Triangles floor = floor_square(2.0, 4).triangles();
  all.conservativeResize(cloth + floor.rows(), 3);
  all.bottomRows(floor.rows()) = floor.array() + n;
  int in_parts = 0;
  for (int step = 0; step < 6; ++step) {
    sim.step();
    in_parts += sim.report().parts > 1;
    for (int i = 1; i < 16; ++i) {
      const Frame frame = sim.frame_at(sim.time() - sim.step_size() * i / 16.0);
      Points vertices(n + frame.body_vertices.rows(), 3);
      vertices << frame.positions, frame.body_vertices;
      CAPTURE(step, i);
      CHECK(intersecting_pairs(vertices, all).empty());
    }
  }
  CHECK(in_parts > 0);
}
