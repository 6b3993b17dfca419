// Tests of scale: a scene and a scaled copy of it behave alike.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/mesh/generators.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// A sheet of 0.25 m that falls over a ball, with folds in contact, scaled by `scale`. Froude
// scaling keeps gravity and area density: membrane stiffness [N/m] grows with the scale, bending
// rigidity [N m] with its third power.
Scene drape(double scale) {
  Scene scene;
  Cloth cloth;
  cloth.mesh =
      share(grid_cells(0.25 * scale, 0.25 * scale, 14, 14).moved(Vec3(0, 0, 0.0525 * scale)));
  cloth.material.weft_stiffness = cloth.material.warp_stiffness = 300.0 * scale;
  cloth.material.shear_stiffness = 150.0 * scale;
  cloth.material.density = 0.3;
  cloth.material.bending_weft = cloth.material.bending_warp = 1e-5 * scale * scale * scale;
  cloth.velocities = Points::Zero(cloth.mesh->n_vertices(), 3);
  cloth.velocities.col(2).setConstant(-6.0 * std::sqrt(scale));
  scene.cloths.push_back(cloth);
  Obstacle ball;
  ball.mesh = share(icosphere(0.05 * scale, 2));
  scene.obstacles.push_back(ball);
  return scene;
}

}  // namespace

TEST_CASE("a scene has no length of its own: scaled by powers of two it gives the same bits") {
  // If lengths are multiplied by a power of four, times and velocities are multiplied by a power of
  // two. Multiplication by powers of two is exact, so rounding errors scale like the numbers.
  const auto end_of = [](double scale) {
    Simulation sim(drape(scale), step_of(4e-3 * std::sqrt(scale)), 1);
    std::int64_t impacts = 0, contacts = 0;
    for (int i = 0; i < 50; ++i) {
      sim.step();
      impacts += sim.report().contacts.impacts;
      contacts = std::max(contacts, sim.report().contacts.near);
    }
    CHECK(contacts > 20);
    CHECK(impacts > 0);
    return sim.positions();
  };
  const Points one = end_of(1.0);
  for (int k = -3; k <= 4; ++k) {
    const double scale = std::pow(4.0, k);
    CAPTURE(scale);
    CHECK((end_of(scale) / scale - one).cwiseAbs().maxCoeff() == 0.0);
  }
}
