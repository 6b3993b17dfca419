// Time and events of asynchronous steps compared with those of symplectic Euler, whose step is the
// shortest step of any triangle. All meshes are jittered; in two of three, triangles also become
// smaller towards the centre. A sheet of 2 m hangs from two corners and swings, without collisions
// and without damping. Times are processor times of one thread for the steps alone, per second of
// motion. The columns "less" and "fewer" give the time and the events of symplectic Euler divided
// by those of the row.
//   benchmark_asynchronous [cells ...]
// Default: 34 and 50 cells along a side (2,312 and 5,000 triangles). --smoke: 6 cells.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "core/integration/asynchronous/element_steps.h"
#include "tests/support/cloth_fixture.h"
#include "tests/support/ordered_mesh.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

double now() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Square sheet of 2 m whose triangles become smaller towards its centre. Edges parallel to the rim
// are about least / (least + 1) times as long at the centre as at the rim. A large `least` hardly
// changes the jittered grid.
TriangleMesh sheet(Index cells, double least) {
  const TriangleMesh mesh = jittered_grid(2.0, 2.0, cells, cells, 0.24, 5);
  Points x = mesh.vertices();
  for (Index i = 0; i < x.rows(); ++i) {
    const double r = x.row(i).cwiseAbs().maxCoeff();
    x.row(i) *= (least + r) / (least + 1.0);
  }
  return {x, mesh.triangles()};
}

struct Cost {
  double seconds = 0.0, events = 0.0;  // computing time [s] and events, per second of motion
};

struct Swing {
  TriangleMesh mesh;
  std::vector<Index> pins;
  ClothMaterial material;
  double duration;  // [s]

  ClothRun run(const IntegratorOptions& options) const {
    return make_run(mesh, material, options, {1e-5, pins, Vec3(0, 0, -9.81)});
  }
  Cost cost(const IntegratorOptions& options) const {
    ClothRun swing = run(options);
    start(swing, options);
    swing.advance();  // not timed: the first step builds tables
    const int steps = static_cast<int>(std::ceil(duration / swing.step));
    Cost cost;
    const double begin = now();
    for (int i = 0; i < steps; ++i) cost.events += static_cast<double>(swing.advance().events);
    const double motion = steps * swing.step;
    cost.seconds = (now() - begin) / motion;
    if (cost.events == 0.0) cost.events = static_cast<double>(steps) * mesh.n_triangles();
    cost.events /= motion;
    return cost;
  }
};

void print(const char* scheme, const Cost& cost, const Cost& reference) {
  std::printf("  %-32s %10.2f %12.3g %8.2f %8.2f\n", scheme, cost.seconds, cost.events,
              reference.seconds / cost.seconds, reference.events / cost.events);
}

void compare(Index cells, double least, double duration) {
  ClothMaterial material;
  material.weft_stiffness = material.warp_stiffness = 300, material.shear_stiffness = 150;
  material.density = 0.5;
  std::vector<Index> pins = {0, cells};
  const TriangleMesh mesh = ordered(sheet(cells, least), pins);
  const Swing swing{mesh, pins, material, duration};
  Asynchronous nested, together, queue;
  together.bending_multiple = 0.0;
  queue.schedule = Schedule::Queue;
  const ClothRun any = swing.run(nested);
  const Vector steps = ElementSteps(any.model, nested).at_rest();
  std::vector<double> area;
  for (const Corners2& c : any.model.corners.all()) {
    Mat2 edges;
    edges << c.row(1) - c.row(0), c.row(2) - c.row(0);
    area.push_back(0.5 * edges.determinant());
  }
  const auto [small, large] = std::minmax_element(area.begin(), area.end());
  std::printf("%d triangles, areas %.0f : 1, steps %.2g to %.2g s\n",
              static_cast<int>(swing.mesh.n_triangles()), *large / *small, steps.minCoeff(),
              steps.maxCoeff());
  std::printf("  %-32s %10s %12s %8s %8s\n", "", "s / s", "events / s", "less", "fewer");
  SymplecticEuler euler;
  euler.step = steps.minCoeff();
  const Cost reference = swing.cost(euler);
  print("symplectic Euler", reference, reference);
  print("nested", swing.cost(nested), reference);
  print("nested, bending with membrane", swing.cost(together), reference);
  print("queue (binary heap)", swing.cost(queue), reference);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Index> sizes;
  bool smoke = false;
  for (int i = 1; i < argc; ++i) {
    smoke = smoke || std::string(argv[i]) == "--smoke";
    if (const int cells = std::atoi(argv[i]); cells > 0) sizes.push_back(cells);
  }
  if (sizes.empty()) sizes = smoke ? std::vector<Index>{6} : std::vector<Index>{34, 50};
  for (const Index cells : sizes)
    for (const double least : {1e6, 0.15, 0.08}) compare(cells, least, smoke ? 0.005 : 0.1);
  return 0;
}
