#include "tests/benchmarks/step/draped.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/mesh/generators.h"
#include "core/sim/simulation.h"

namespace loomstone {

namespace {

constexpr double side = 0.5, radius = 0.15;
constexpr Index coarse_cells = 40;

Scene scene_with(const TriangleMesh& mesh, const Points& velocities, bool collisions) {
  Scene scene;
  Cloth cloth;
  cloth.mesh = std::make_shared<const TriangleMesh>(mesh);
  cloth.velocities = velocities;
  scene.cloths.push_back(cloth);
  scene.collisions = collisions;
  if (!collisions) return scene;
  scene.allow_initial_intersections = true;  // interpolated cloth may cross itself or the sphere
  const TriangleMesh ball = icosphere(radius, 4);
  Points x = ball.vertices();
  x.rowwise() += Vec3(0.03, 0.02, 0.0).transpose();
  Obstacle obstacle;
  obstacle.mesh = std::make_shared<const TriangleMesh>(x, ball.triangles());
  scene.obstacles.push_back(obstacle);
  return scene;
}

void run(Simulation& sim, int steps) {
  for (int i = 0; i < steps; ++i) sim.step();
}

// Catmull-Rom weights of four neighbours at parameter t between the middle two.
std::array<double, 4> cubic(double t) {
  return {0.5 * t * (-1 + t * (2 - t)), 0.5 * (2 + t * t * (-5 + 3 * t)),
          0.5 * t * (1 + t * (4 - 3 * t)), 0.5 * t * t * (t - 1)};
}

// Interpolates values from a grid of coarse x coarse cells to a grid of fine x fine cells. Beyond
// the border, the coarse values are extrapolated linearly.
Points interpolate(const Points& values, Index coarse, Index fine) {
  const auto at = [&](Index i, Index j) -> Vec3 {
    return values.row(j * (coarse + 1) + i).transpose();
  };
  const auto along = [&](Index i, Index j) -> Vec3 {
    if (i < 0) return 2.0 * at(0, j) - at(1, j);
    if (i > coarse) return 2.0 * at(coarse, j) - at(coarse - 1, j);
    return at(i, j);
  };
  const auto value = [&](Index i, Index j) -> Vec3 {
    if (j < 0) return 2.0 * along(i, 0) - along(i, 1);
    if (j > coarse) return 2.0 * along(i, coarse) - along(i, coarse - 1);
    return along(i, j);
  };
  Points result((fine + 1) * (fine + 1), 3);
  for (Index j = 0; j <= fine; ++j)
    for (Index i = 0; i <= fine; ++i) {
      const double x = static_cast<double>(i * coarse) / fine,
                   y = static_cast<double>(j * coarse) / fine;
      const Index cx = std::min(coarse - 1, static_cast<Index>(x)),
                  cy = std::min(coarse - 1, static_cast<Index>(y));
      const auto wx = cubic(x - cx), wy = cubic(y - cy);
      Vec3 sum = Vec3::Zero();
      for (int b = 0; b < 4; ++b)
        for (int a = 0; a < 4; ++a) sum += wx[a] * wy[b] * value(cx + a - 1, cy + b - 1);
      result.row(j * (fine + 1) + i) = sum.transpose();
    }
  return result;
}

// Returns the positions of the coarse cloth 1.2 s after it is dropped.
Points settled() {
  TriangleMesh flat = grid_cells(side, side, coarse_cells, coarse_cells);
  Points x = flat.vertices();
  x.col(2).array() += radius + 0.006;
  IntegratorOptions options;
  options.set_step(4e-3);
  Simulation sim(scene_with(TriangleMesh(x, flat.triangles(), flat.uv()), {}, true), options);
  run(sim, 300);
  return sim.positions();
}

}  // namespace

Draped drape(Index cells) {
  static const Points coarse = settled();
  const TriangleMesh flat = grid_cells(side, side, cells, cells);
  const TriangleMesh start(interpolate(coarse, coarse_cells, cells), flat.triangles(), flat.uv());
  IntegratorOptions options;
  Simulation sim(scene_with(start, {}, true), options);
  run(sim, 10);
  return {TriangleMesh(sim.positions(), flat.triangles(), flat.uv()), sim.velocities()};
}

Scene draped_scene(const Draped& draped) {
  return scene_with(draped.mesh, draped.velocities, false);
}

}  // namespace loomstone
