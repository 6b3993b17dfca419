#include "core/sim/step/checks.h"

#include <cmath>
#include <sstream>

#include "core/base/error.h"
#include "core/collision/tangle/intersections.h"
#include "core/sim/model/motion.h"

namespace loomstone {

namespace {

// Returns whether the first n vertices are at most `most` [m] away from their positions in x0 and
// have finite velocities.
bool all_within(const Points& x0, const ClothState& cloth, Index n, double most) {
  const double *a = x0.data(), *b = cloth.x.data(), *v = cloth.v.data();
  const double most2 = most * most;
  int within = 1;
  for (Index i = 0; i < n; ++i, a += 3, b += 3, v += 3) {
    const double x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
    // An infinite number or NaN minus itself is NaN.
    const double zero = (v[0] - v[0]) + (v[1] - v[1]) + (v[2] - v[2]);
    within &= static_cast<int>(x * x + y * y + z * z <= most2) & static_cast<int>(zero == 0.0);
  }
  return within != 0;
}

}  // namespace

void check_divergence(const Model& model, const Points& x0, const ClothState& cloth,
                      const char* stage) {
  const double allowed = 100.0 * model.cloth_size;
  if (all_within(x0, cloth, model.cloth.n_vertices, allowed)) return;
  Index worst = -1;
  double most = allowed;
  for (Index i = 0; i < model.cloth.n_vertices; ++i) {
    const double moved = (cloth.x.row(i) - x0.row(i)).norm();
    const bool finite = std::isfinite(moved) && cloth.v.row(i).allFinite();
    if (moved > most || (worst < 0 && !finite)) {
      worst = i;
      most = std::fmax(most, moved);
    }
  }
  if (worst < 0) return;
  std::ostringstream out;
  const double moved = (cloth.x.row(worst) - x0.row(worst)).norm();
  out << "cloth vertex " << model.vertex_of_row(worst);
  if (moved > allowed && std::isfinite(moved))
    out << " moved by " << moved << " m in the stage \"" << stage
        << "\", more than 100 times the size of the cloths";
  else
    out << " has a position or velocity that is not finite after the stage \"" << stage << '"';
  out << "; shorten integrator.step";
  throw SolverFailure(out.str());
}

void count_intersections(State& state, Engines& engines, StepOutcome& outcome) {
  const CollisionModel& surfaces = engines.model.collision;
  Points x1;
  collision_vertices(engines.model, state, x1);
  const std::vector<std::array<Index, 2>> pairs = cloth_intersections(surfaces, x1);
  outcome.report.contacts.intersections = static_cast<std::int64_t>(pairs.size());
  // The state stays tangled until both cloth_intersections() and find_tangle() find nothing.
  // cloth_intersections() skips pairs of triangles that share a vertex. It thus misses an edge that
  // pierces a triangle if all triangles at this edge share a vertex with the pierced one.
  if (pairs.empty() && engines.collision->find_tangle(x1).empty()) state.tangled = 0;
  if (state.tangled != 2) return;
  outcome.forced = pairs;
  outcome.report.contacts.forced = outcome.report.contacts.intersections;
  for (const auto& pair : pairs)
    for (const Index triangle : pair)
      for (int k = 0; k < 3; ++k)
        if (const Index v = surfaces.triangles(triangle, k); v < engines.model.cloth.n_vertices)
          outcome.contact[v] = 2;
}

void measure_contacts(const Model& model, const State& state, double step, StepOutcome& outcome) {
  StepReport& report = outcome.report;
  report.withheld.share =
      report.withheld.requested > 0.0 ? report.withheld.motion / report.withheld.requested : 0.0;
  const Points& v0 = outcome.start.cloth.v;
  double squares = 0.0;
  std::int64_t count = 0;
  for (Index i = 0; i < model.cloth.n_vertices; ++i) {
    if (outcome.contact[i] == 0 || model.cloth.prescribed[i]) continue;
    squares += (state.cloth.v.row(i) - v0.row(i)).squaredNorm();
    ++count;
  }
  report.contacts.acceleration =
      count > 0 ? std::sqrt(squares / static_cast<double>(count)) / step : 0.0;
}

}  // namespace loomstone
