// Measures the times of the collision stages [ms]. The usual test run excludes this test; the
// command test_collision "[timing]" runs it.
#include <catch2/catch.hpp>

#include <chrono>
#include <cstdio>
#include <ctime>

#include "core/collision/collision_stage.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;
using Kind = CollisionSurface::Kind;

namespace {

// Returns the wall time [ms] if there are several threads. For one thread, returns the processor
// time [ms], which other programs hardly affect.
double milliseconds(int threads) {
  if (threads == 1) {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * t.tv_sec + 1e-6 * t.tv_nsec;
  }
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// Cloth of 14,450 triangles draped over a sphere of 5,120 triangles. The vertices of the draped
// part are 0.35 mm outside the sphere, and the rest of the cloth hangs down. The thickness is 0.6
// mm.
TestScene drape() {
  TestScene scene = make_scene({{grid_cells(0.5, 0.5, 85, 85), Kind::Cloth, 0.6e-3},
                                {icosphere(0.15, 4), Kind::Script, 0.6e-3}});
  scene.model.surfaces[1].smooth = true;
  const double radius = 0.15 + 0.35e-3;
  for (Index i = 0; i < scene.model.surfaces[0].n_vertices; ++i) {
    const double x = scene.x(i, 0), y = scene.x(i, 1), r = std::hypot(x, y), arc = radius * 1.4;
    const double angle = std::min(r, arc) / radius, beyond = std::max(0.0, r - arc);
    const double out = r > 0.0 ? radius * std::sin(angle) + beyond * std::cos(angle) : 0.0;
    scene.x.row(i) << (r > 0 ? x / r * out : 0.0), (r > 0 ? y / r * out : 0.0),
        radius * std::cos(angle) - beyond * std::sin(angle);
  }
  return scene;
}

}  // namespace

TEST_CASE("time of a step", "[.timing]") {
  const TestScene scene = drape();
  const Index n = scene.model.surfaces[0].n_vertices;
  for (const double travel : {1e-6, 5e-5, 1e-3, 5e-3})
    for (const int threads : {1, 2}) {
      CollisionStage stage(scene.model);
      double proximity = 1e9, terms_time = 1e9, certify = 1e9, total = 1e9, mean = 0.0;
      std::size_t n_contacts = 0;
      std::int64_t impacts = 0;
      Points x = scene.x;
      ExtraTerms terms;
      ContactState state;
      const int n_steps = 40;
      for (int step = 0; step < n_steps; ++step) {
        Points x1 = x;
        for (Index i = 0; i < n; ++i)
          x1.row(i) += travel * std::sin(0.001 * i + step) * Eigen::RowVector3d(0.6, 0.3, 0.4);
        const double t0 = milliseconds(threads);
        const auto contacts = stage.proximity(Team{threads}, x, {});
        const double t1 = milliseconds(threads) - t0;
        terms.clear();
        const Points unchanged = Points::Zero(x.rows(), 3);
        const ContactTerms made =
            stage.terms(Team{threads},
                        {x, x1, unchanged, Points(0, 3), 1e-3, n, scene.inverse_mass, Points(0, 3)},
                        contacts, state, terms);
        stage.update_anchors(contacts, made, x, x1, state);
        const double t2 = milliseconds(threads) - t0;
        FreeBodies none;
        const CertifyReport report =
            stage.certify(Team{threads}, {x, scene.inverse_mass, {}}, x1, none);
        const double t3 = milliseconds(threads) - t0;
        proximity = std::min(proximity, t1);
        terms_time = std::min(terms_time, t2 - t1);
        certify = std::min(certify, t3 - t2);
        total = std::min(total, t3);
        mean += t3 / n_steps;
        n_contacts = contacts.size();
        impacts = report.impacts;
        x = x1;
      }
      std::printf(
          "travel %g threads %d: proximity %.2f terms+anchors %.2f certify %.2f total %.2f mean "
          "%.2f ms; contacts %zu impacts %ld\n",
          travel, threads, proximity, terms_time, certify, total, mean, n_contacts, long(impacts));
    }
}
