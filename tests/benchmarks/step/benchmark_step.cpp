// Time of a step (loads, forces, assembly, solve, motion) of a cloth draped over a sphere, without
// collisions. Compares solvers and bending elements, mesh sizes, numbers of threads, and the errors
// at several tolerances of the solver. All repetitions start from the same state, except that every
// second repetition displaces one vertex by 1 nm. The smallest time is printed. A matrix-vector
// product of fixed size (7,396 block rows, one thread) is timed between the repetitions. Step times
// depend on the machine. Their ratio to the time of this product depends much less on the machine.
//   benchmark_step [solvers] [growth [cells ...]] [accuracy] [threads]      (default: all; growth
//   of 50 ... 400 cells per edge; --smoke: one row, for 10 cells per edge)
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>

#include "core/linalg/block_matrix.h"
#include "core/mesh/generators.h"
#include "core/sim/simulation.h"
#include "tests/benchmarks/step/draped.h"

using namespace loomstone;

namespace {

// Returns the wall time [s] if there are several threads. For one thread, returns the processor
// time [s], which other processes hardly affect.
double now(int threads = 1) {
  timespec t;
  clock_gettime(threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

const Draped& draped(Index cells) {
  static std::map<Index, Draped> made;
  const auto found = made.find(cells);
  return found != made.end() ? found->second : made.emplace(cells, drape(cells)).first->second;
}

struct Case {
  Index cells = 85;
  double step = 1e-3;
  const char* solver = "pcg";
  const char* bending = "explicit";
  const char* element = "mid-edge";
  int threads = 1;
  double tolerance = 1e-4;
};

Simulation simulation(const Case& c) {
  Scene scene = draped_scene(draped(c.cells));
  scene.cloths[0].bending = choice_named<BendingElement>(c.element, "element");
  SemiImplicitEuler options;
  options.step = c.step, options.tolerance = c.tolerance;
  options.linear_solver = choice_named<LinearMethod>(c.solver, "solver");
  options.bending = choice_named<BendingInStep>(c.bending, "bending");
  return Simulation(scene, options, c.threads);
}

// Measures the time of the product y = A x, where A has the pattern of a membrane of 85 x 85 cells.
class Product {
 public:
  Product() {
    const TriangleMesh mesh = grid_cells(0.5, 0.5, 85, 85);
    std::vector<std::pair<Index, Index>> couplings;
    for (Index t = 0; t < mesh.n_triangles(); ++t)
      for (int k = 0; k < 3; ++k)
        couplings.emplace_back(mesh.triangles()(t, k), mesh.triangles()(t, (k + 1) % 3));
    a_ = BlockMatrix(mesh.n_vertices(), couplings);
    x_.assign(4 * mesh.n_vertices() + 4, 1.0);
    y_ = x_;
  }
  // Mean time of a product [s] over 64 products.
  double time() {
    const double start = now();
    for (int i = 0; i < 64; ++i) a_.multiply(0, a_.n_rows(), x_.data(), y_.data());
    return (now() - start) / 64;
  }

 private:
  BlockMatrix a_;
  std::vector<double> x_, y_;
};

struct Measured {
  double step = 1e9, product = 1e9;  // smallest times of a step and of a product [s]
  int iterations = 0;
};

Measured measure(const Case& c) {
  static Product product;
  Simulation sim = simulation(c);
  const Points x = sim.positions(), v = sim.velocities();
  // Alternating start positions prevent a step from reusing quantities that were cached for the
  // start positions of the previous repetition.
  Points beside = x;
  beside(0, 0) += 1e-9;
  const int repetitions = c.cells > 130 ? 20 : 40;
  Measured best;
  for (int i = 0; i < repetitions + 2; ++i) {
    sim.set_positions(i % 2 == 0 ? x : beside);
    sim.set_velocities(v);
    const double start = now(c.threads);
    sim.step();
    // The first two steps are not counted, because they also allocate memory.
    if (i >= 2) best.step = std::min(best.step, now(c.threads) - start);
    best.product = std::min(best.product, product.time());
  }
  best.iterations = sim.report().solver.linear_iterations;
  return best;
}

void print_header() {
  std::printf(
      "# triangles  h [ms]  solver        bending   element   threads  iterations  step [ms]  "
      "product [ms]  "
      "step/product\n");
}

Measured print(const Case& c) {
  const Measured m = measure(c);
  std::printf("step %8d  %6.2f  %-12s  %-8s  %-8s  %7d  %10d  %9.2f  %12.4f  %12.0f\n",
              static_cast<int>(2 * c.cells * c.cells), 1e3 * c.step, c.solver, c.bending, c.element,
              c.threads, m.iterations, 1e3 * m.step, 1e3 * m.product, m.step / m.product);
  std::fflush(stdout);
  return m;
}

void solvers() {
  print_header();
  for (const double h : {1e-3, 4e-3})
    for (const char* solver : {"pcg", "block-jacobi", "gauss-seidel", "direct", "supernodal"}) {
      print({85, h, solver, "explicit", "mid-edge"});
      print({85, h, solver, "explicit", "hinge"});
      print({85, h, solver, "implicit", "hinge"});
      print({85, h, solver, "implicit", "mid-edge"});
    }
}

void growth(const std::vector<Index>& cells) {
  print_header();
  for (const Index n : cells)
    for (const double h : {1e-3, 4e-3})
      for (const char* solver : {"pcg", "block-jacobi", "supernodal"}) {
        // Supernodal runs are limited to smaller meshes, which suffice to show how their time
        // grows.
        if (std::string(solver) == "supernodal" && n > 130) continue;
        print({n, h, solver, h > 2e-3 ? "implicit" : "explicit"});
      }
}

void threads() {
  print_header();
  for (const double h : {1e-3, 4e-3}) {
    const double one = print({170, h}).step,
                 two = print({170, h, "pcg", "explicit", "mid-edge", 2}).step;
    std::printf("two threads: %.2f times one\n", one / two);
  }
}

// For each mesh, step and tolerance of the solver, prints the mean number of iterations, and the
// largest distance after 50 steps between a vertex and its position with the direct solver.
void accuracy() {
  std::printf(
      "# cells  h [ms]  bending   element   tolerance  iterations  largest error after 50 steps "
      "[mm]\n");
  for (const Index cells : {50, 85})
    for (const double h : {1e-3, 2e-3, 4e-3}) {
      const char* bending = h > 1.2e-3 ? "implicit" : "explicit";
      Simulation exact = simulation({cells, h, "direct", bending});
      for (int i = 0; i < 50; ++i) exact.step();
      const Points reference = exact.positions();
      for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        Simulation sim = simulation({cells, h, "pcg", bending, "mid-edge", 1, tolerance});
        int iterations = 0;
        for (int i = 0; i < 50; ++i) {
          sim.step();
          iterations += sim.report().solver.linear_iterations;
        }
        std::printf("accuracy %4d  %6.2f  %-8s  %-8s  %9.0e  %10.1f  %.3g\n", cells, 1e3 * h,
                    bending, "mid-edge", tolerance, iterations / 50.0,
                    1e3 * (reference - sim.positions()).rowwise().norm().maxCoeff());
        std::fflush(stdout);
      }
    }
}

}  // namespace

int main(int argc, char** argv) {
  const auto asked = [&](const char* name) {
    return argc == 1 || std::any_of(argv + 1, argv + argc,
                                    [&](const char* word) { return std::string(word) == name; });
  };
  std::vector<Index> cells;
  for (int i = 1; i < argc; ++i)
    if (const int n = std::atoi(argv[i]); n > 0) cells.push_back(n);
  if (argc == 2 && asked("--smoke")) {
    print_header();
    print({10});
    return 0;
  }
  if (asked("solvers")) solvers();
  if (asked("accuracy")) accuracy();
  if (asked("threads")) threads();
  if (asked("growth"))
    growth(cells.empty() ? std::vector<Index>{50, 85, 120, 170, 240, 400} : cells);
}
