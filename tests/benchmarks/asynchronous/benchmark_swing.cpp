// Energy and stretch of a swinging sheet with asynchronous steps, [Thomaszewski2010], example 4.1:
// a square of 2 m that hangs from two corners is released flat, without damping or collisions. The
// table lists the largest stretch, and the change of the energy since the start in percent of the
// largest kinetic energy, as means over the middle tenth and the last tenth of the time. Events are
// per triangle, and times are processor times of one thread for the steps alone; both are per
// second of motion. In the rows with a potential or impulses, the strain limits are 7.5 %.
//   benchmark_swing [cells [duration [rows]]]
// Default: 16 cells along a side (512 triangles; 50 cells: 5,000 triangles), 4 s, all rows of the
// table. --smoke: 4 cells, 0.01 s.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iterator>
#include <string>

#include "tests/support/cloth_fixture.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

constexpr double largest_strain = 0.075;

double now() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Case {
  const char* name;
  Schedule schedule;
  Limiting limiting;
  bool by_edges;
};

struct Totals {
  double seconds = 0.0, events = 0.0, stretch = 0.0, peak = 0.0, middle = 0.0, last = 0.0;
};

Totals totals(ClothRun& run, int steps) {
  const double begin = run.energy();
  const int tenth = std::max(1, steps / 10);
  Totals sum;
  Points green;
  Vector stretch;
  for (int i = 0; i < steps; ++i) {
    const double before = now();
    sum.events += static_cast<double>(run.advance().events);
    sum.seconds += now() - before;
    run.elasticity->strain({}, run.state.x, green, stretch);
    sum.stretch = std::max(sum.stretch, stretch.maxCoeff());
    sum.peak = std::max(sum.peak, run.kinetic_energy());
    const double gain = (run.energy() - begin) / tenth;
    if (std::abs(2 * i - steps) < tenth) sum.middle += gain;
    if (i >= steps - tenth) sum.last += gain;
  }
  return sum;
}

void measure(const Case& which, Index cells, double duration) {
  ClothMaterial material;
  material.weft_stiffness = material.warp_stiffness = 300, material.shear_stiffness = 150;
  material.density = 0.5;
  Asynchronous options;
  options.schedule = which.schedule, options.limiting = which.limiting;
  ClothRun run = make_run(jittered_grid(2.0, 2.0, cells, cells, 0.24, 5), material, options,
                          {1e-5, {0, cells}, Vec3(0, 0, -9.81)});
  StrainLimit limit;
  limit.weft = limit.warp = limit.shear = largest_strain;
  run.model.strain_limits = {limit};
  run.model.strain_limit_of.assign(run.model.triangles.rows(), 0);
  run.model.limited_by_edges = which.by_edges;
  start(run, options);
  const double interval = options.step.given.value();
  const int steps = std::max(1, static_cast<int>(std::lround(duration / interval)));
  std::printf("  %-30s", which.name);
  try {
    const Totals t = totals(run, steps);
    std::printf(" %8.3f %9.3f %9.3f %12.0f %8.2f\n", t.stretch, 100.0 * t.middle / t.peak,
                100.0 * t.last / t.peak, t.events / (steps * interval * run.model.triangles.rows()),
                t.seconds / (steps * interval));
  } catch (const StepFailure& failure) {
    std::printf(" fails after %.2f s: %s\n", run.steps * interval, failure.what());
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const bool smoke = argc > 1 && std::string(argv[1]) == "--smoke";
  const Index cells = smoke ? 4 : argc > 1 ? std::atoi(argv[1]) : 16;
  const double duration = smoke ? 0.01 : argc > 2 ? std::atof(argv[2]) : 4.0;
  std::printf("%d triangles, %g s\n  %-30s %8s %9s %9s %12s %8s\n", 2 * cells * cells, duration, "",
              "stretch", "middle %", "last %", "events / s", "s / s");
  const Case cases[] = {
      Case{"nested", Schedule::Nested, Limiting::None, false},
      Case{"queue", Schedule::Queue, Limiting::None, false},
      Case{"refill", Schedule::Refill, Limiting::None, false},
      Case{"nested, potential", Schedule::Nested, Limiting::Potential, false},
      Case{"nested, potential, edges", Schedule::Nested, Limiting::Potential, true},
      Case{"nested, impulses", Schedule::Nested, Limiting::Impulses, false},
      Case{"nested, impulses, edges", Schedule::Nested, Limiting::Impulses, true},
      Case{"queue, potential", Schedule::Queue, Limiting::Potential, false},
      Case{"queue, impulses", Schedule::Queue, Limiting::Impulses, false}};
  const int rows = !smoke && argc > 3 ? std::atoi(argv[3]) : static_cast<int>(std::size(cases));
  for (int i = 0; i < std::min(rows, static_cast<int>(std::size(cases))); ++i)
    measure(cases[i], cells, duration);
  return 0;
}
