// Time of a step without collisions (forces, assembly, solve) of a cloth in a draped shape, its growth with the mesh, and
// the accuracy of the default tolerance. Times are minima of the repetitions, printed beside a fixed block product of the
// same run: the ratio is the claim, milliseconds depend on the machine.
//   benchmark_step [triangles ...]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/linalg/block_matrix.h"
#include "core/mesh/generators.h"
#include "core/sim/simulation.h"

using namespace loomstone;

namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// A sheet bent over a ball with folds in its skirt: strained by a few per cent everywhere, as draped cloth is.
TriangleMesh draped(Index triangles) {
  const TriangleMesh flat = grid(0.5, 0.5, triangles);
  Points x = flat.vertices();
  for (Index i = 0; i < x.rows(); ++i) {
    const double r = std::hypot(x(i, 0), x(i, 1)), angle = std::atan2(x(i, 1), x(i, 0));
    const double polar = std::min(r / 0.15, 1.4), below = std::max(r - 0.21, 0.0);
    const double radius = 0.15 * std::sin(polar) + 0.2 * below * (1.0 + 0.8 * std::cos(8 * angle));
    x.row(i) << radius * std::cos(angle), radius * std::sin(angle), 0.15 * std::cos(polar) - 0.95 * below;
  }
  return TriangleMesh(x, flat.triangles(), flat.uv());
}

Scene scene_of(Index triangles) {
  Scene scene;
  scene.collisions = false;
  Cloth cloth;
  cloth.mesh = std::make_shared<const TriangleMesh>(draped(triangles));
  scene.cloths.push_back(cloth);
  return scene;
}

IntegratorOptions options_of(double h, const char* solver, const char* bending, double tolerance = 1e-4) {
  IntegratorOptions o;
  o.step = h, o.linear_solver = solver, o.bending = bending, o.tolerance = tolerance;
  return o;
}

// y = A x of the membrane's pattern at 7,396 vertices [s].
double product_time() {
  const TriangleMesh mesh = grid(0.5, 0.5, 14450);
  std::vector<std::pair<Index, Index>> couplings;
  for (Index t = 0; t < mesh.n_triangles(); ++t)
    for (int k = 0; k < 3; ++k) couplings.emplace_back(mesh.triangles()(t, k), mesh.triangles()(t, (k + 1) % 3));
  const BlockMatrix a(mesh.n_vertices(), couplings);
  std::vector<double> x(4 * mesh.n_vertices() + 4, 1.0), y(x);
  double best = 1e9;
  for (int i = 0; i < 200; ++i) {
    const double start = now();
    a.multiply(0, mesh.n_vertices(), x.data(), y.data());
    best = std::min(best, now() - start);
  }
  return best;
}

void time_step(Index triangles, double h, const char* solver, const char* bending, int threads, double product) {
  Simulation sim(scene_of(triangles), options_of(h, solver, bending), threads);
  sim.step();  // builds patterns
  const int repetitions = triangles > 100000 ? 5 : 20;
  double best = 1e9;
  int iterations = 0;
  for (int i = 0; i < repetitions; ++i) {
    const double start = now();
    sim.step();
    best = std::min(best, now() - start);
    iterations = std::max(iterations, sim.report().linear_iterations);
  }
  std::printf("%9d  %5.0f us  %-13s %-9s %d  %5d  %9.2f ms  %8.0f products\n", static_cast<int>(sim.topology().triangles.rows()),
              1e6 * h, solver, bending, threads, iterations, 1e3 * best, best / product);
  std::fflush(stdout);
}

// Positions after 50 steps at the default tolerance against a direct solve.
void accuracy(double h, const char* bending, double tolerance) {
  Simulation exact(scene_of(5000), options_of(h, "direct", bending), 2);
  Simulation loose(scene_of(5000), options_of(h, "pcg", bending, tolerance), 2);
  for (int i = 0; i < 50; ++i) exact.step(), loose.step();
  std::printf("5,000 triangles, h = %.0f us, bending %s, tolerance %g: %.3g mm off after 50 steps\n", 1e6 * h, bending,
              tolerance, 1e3 * (exact.positions() - loose.positions()).rowwise().norm().maxCoeff());
}

}  // namespace

int main(int argc, char** argv) {
  const double product = product_time();
  std::printf("block product, 7,396 rows: %.4f ms\n", 1e3 * product);
  std::printf("triangles   step      solver        bending   threads  iterations\n");
  std::vector<Index> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::atoi(argv[i]));
  if (sizes.empty()) {
    for (const double h : {1e-3, 4e-3})
      for (const char* solver : {"pcg", "gauss-seidel", "direct"})
        for (const char* bending : {"explicit", "implicit"}) time_step(14450, h, solver, bending, 1, product);
    sizes = {5000, 14450, 58000, 115000, 320000};
  }
  for (const Index triangles : sizes)
    for (const int threads : {1, 2}) time_step(triangles, 1e-3, "pcg", "explicit", threads, product);
  for (const double tolerance : {1e-3, 1e-4, 1e-6}) accuracy(1e-3, "explicit", tolerance);
  for (const double tolerance : {1e-3, 1e-4, 1e-6}) accuracy(4e-3, "implicit", tolerance);
}
