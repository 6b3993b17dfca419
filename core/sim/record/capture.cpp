#include "core/sim/record/capture.h"

#include <algorithm>
#include <cmath>

#include "core/cloth/limits/strain_limiter.h"
#include "core/electrodynamics/coil_currents.h"
#include "core/sim/model/motion.h"
#include "core/sim/step/energies.h"
#include "core/sim/step/energy_account.h"

namespace loomstone {

namespace {

void measure_strain(const Engines& engines, const Points& x, StrainReport& report) {
  report = StrainReport{};
  if (x.rows() == 0) return;
  Points green;
  Vector stretch;
  engines.elasticity->strain(engines.team, x, green, stretch);
  report.stretch = stretch.maxCoeff();
  report.weft = report.warp = -1.0;
  for (Index t = 0; t < green.rows(); ++t) {
    const Vec3 strain = corotational_strain(Vec3(green.row(t).transpose()));
    report.weft = std::max(report.weft, strain[0]);
    report.warp = std::max(report.warp, strain[1]);
    report.shear = std::max(report.shear, std::abs(strain[2]));
  }
}

// Sets the strain and stretch of each triangle, in the user's order. The positions `x` (n x 3) [m]
// are in row order.
void capture_strain(const Engines& engines, const Points& x, Frame& frame) {
  const std::vector<Index>& triangle_of = engines.model.triangle_of;
  const Index m = static_cast<Index>(triangle_of.size());
  frame.strain.resize(m, 3);
  frame.stretch.resize(m);
  if (m == 0) return;
  Points green;
  Vector stretch;
  engines.elasticity->strain(engines.team, x, green, stretch);
  for (Index t = 0; t < m; ++t) {
    frame.strain.row(triangle_of[t]) = green.row(t);
    frame.stretch[triangle_of[t]] = stretch[t];
  }
  frame.report.strain.stretch = stretch.maxCoeff();
}

// Returns the positions of all collision vertices when the fraction `share` of the last step has
// passed. They lie on the straight paths over the parts of the step, which certification has
// checked.
Points vertices_at(const Model& model, const State& state, const StepOutcome& outcome,
                   double share) {
  PathPoint from, to{1.0, {}};
  collision_vertices(model, state, to.vertices);
  if (share >= 1.0) return to.vertices;
  collision_vertices(model, outcome.start, from.vertices);
  for (const PathPoint& point : outcome.path) {
    if (point.share <= share)
      from = point;
    else if (point.share < to.share)
      to = point;
  }
  const double passed = (share - from.share) / (to.share - from.share);
  return from.vertices + passed * (to.vertices - from.vertices);
}

}  // namespace

void measure(const State& state, double time, const Engines& engines, StepReport& report) {
  measure_energies(state, time, engines, report);
  measure_strain(engines, state.cloth.x, report.strain);
  report_account(state, report);
}

Frame capture(const State& state, const StepOutcome& outcome, const Engines& engines,
              FrameTime at) {
  const Model& model = engines.model;
  const Index n = model.cloth.n_vertices;
  Frame frame;
  frame.step = state.step;
  frame.time = at.time;
  frame.report = outcome.report;
  frame.coil_currents = coil_currents(model.magnetics, state.magnetic.circuits, frame.time);
  const Points vertices = vertices_at(model, state, outcome, at.share);
  const Points rows = vertices.topRows(n);
  frame.body_vertices = vertices.bottomRows(vertices.rows() - n);
  frame.positions.resize(n, 3);
  frame.velocities.resize(n, 3);
  frame.contact.assign(n, 0);
  for (Index vertex = 0; vertex < n; ++vertex) {
    const Index row = model.row_of_vertex[vertex];
    frame.positions.row(vertex) = rows.row(row);
    frame.velocities.row(vertex) = state.cloth.v.row(row);
    if (!outcome.contact.empty()) frame.contact[vertex] = outcome.contact[row];
  }
  capture_strain(engines, rows, frame);
  return frame;
}

std::vector<Wrench> magnetic_forces(const State& state, double time, const Engines& engines) {
  const Model& model = engines.model;
  if (!engines.magnetics) return std::vector<Wrench>(model.n_bodies());
  return engines.magnetics->wrenches(engines.team,
                                     {state.rigid, obstacle_places(model, state, time, 0.0).poses},
                                     coil_currents(model.magnetics, state.magnetic.circuits, time));
}

}  // namespace loomstone
