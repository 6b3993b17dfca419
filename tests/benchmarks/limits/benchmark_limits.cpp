// Time of one sweep of strain limiting (evaluation and correction; see sweep()) over elements that
// exceed their limits, and of a call of StrainLimiter::enforce() on one thread if all elements are
// within limits (see idle()). The time of a call is the minimum of 40 repetitions. The column
// sweep/product is the time of a sweep divided by that of a block matrix-vector product (7,396
// rows, one thread) in the same run. Results of different machines can be compared only by this
// ratio.
//   benchmark_limits [cells ...]      (default 42, 85, 224: 3,528, 14,450 and 100,352 triangles;
//   --smoke: 10)
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "core/linalg/block_matrix.h"
#include "tests/cloth/limits/limit_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

double now(int threads) {
  timespec t;
  clock_gettime(threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double product() {
  const TriangleMesh mesh = grid_cells(0.5, 0.5, 85, 85);
  std::vector<std::pair<Index, Index>> couplings;
  for (Index t = 0; t < mesh.n_triangles(); ++t)
    for (int k = 0; k < 3; ++k)
      couplings.emplace_back(mesh.triangles()(t, k), mesh.triangles()(t, (k + 1) % 3));
  const BlockMatrix a(mesh.n_vertices(), couplings);
  std::vector<double> x(4 * mesh.n_vertices() + 4, 1.0), y = x;
  double best = 1e9;
  for (int i = 0; i < 40; ++i) {
    const double start = now(1);
    for (int k = 0; k < 16; ++k) a.multiply(0, a.n_rows(), x.data(), y.data());
    best = std::min(best, (now(1) - start) / 16);
  }
  return best;
}

// Seconds per sweep: the time of 9 sweeps minus the time of 1 sweep, divided by 8. The difference
// cancels the time of work that is done once per call.
double sweep(const LimitedCloth& cloth, const Points& x, const char* method, int threads) {
  double best[2] = {1e9, 1e9};
  for (int several = 0; several < 2; ++several) {
    StrainLimiter limiter(cloth, sweeping(method, 1e-12, several ? 9 : 1, false));
    for (int i = 0; i < 40; ++i) {
      Points moved = x;
      const double start = now(threads);
      limiter.enforce({threads}, 1, {}, moved);
      best[several] = std::min(best[several], now(threads) - start);
    }
  }
  return (best[1] - best[0]) / 8;
}

// Time [s] of a call that finds nothing to correct. The call checks all elements; edge-based
// limiting also performs one sweep.
double idle(const LimitedCloth& cloth, const Points& x, const char* method) {
  StrainLimiter limiter(cloth, sweeping(method));
  double best = 1e9;
  for (int i = 0; i < 40; ++i) {
    Points moved = x;
    const double start = now(1);
    limiter.enforce({}, 1, {}, moved);
    best = std::min(best, now(1) - start);
  }
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Index> cells;
  for (int i = 1; i < argc; ++i)
    cells.push_back(std::string(argv[i]) == "--smoke" ? 10 : std::atoi(argv[i]));
  if (cells.empty()) cells = {42, 85, 224};
  const double unit = product();
  std::printf(
      "block product %.4f ms\n# triangles  method               threads  sweep [ms]  per 3,600 "
      "[ms]  sweep/product  idle call [ms]\n",
      1e3 * unit);
  for (const Index n : cells) {
    const TriangleMesh mesh = jittered_grid(1.0, 1.0, n, n, 0.2, 1);
    StrainLimit limit;
    limit.weft = 0.02, limit.warp = 0.03, limit.shear = 0.02;
    const LimitedCloth cloth = sheet(mesh, limit, {0});
    Points x = mesh.vertices();
    for (Index i = 0; i < x.rows(); ++i) {
      const double u = x(i, 0), v = x(i, 1);
      x(i, 0) += 0.3 * u + 0.1 * std::sin(7 * v), x(i, 1) += 0.2 * v + 0.1 * std::sin(5 * u);
    }
    for (const char* method : {"gauss-seidel", "gauss-seidel-random", "jacobi", "edges"})
      for (const int threads : {1, 2}) {
        if (threads == 2 && std::string(method) == "gauss-seidel-random") continue;
        const double time = sweep(cloth, x, method, threads);
        std::printf("%10d   %-20s %6d  %10.4f  %14.4f  %13.2f  %14.4f\n",
                    static_cast<int>(mesh.n_triangles()), method, threads, 1e3 * time,
                    1e3 * time * 3600 / mesh.n_triangles(), time / unit,
                    1e3 * idle(cloth, mesh.vertices(), method));
        std::fflush(stdout);
      }
  }
}
