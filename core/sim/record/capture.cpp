#include "core/sim/record/capture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/cloth/limits/strain_limiter.h"
#include "core/electrodynamics/coil_currents.h"
#include "core/parallel/shared_work.h"
#include "core/sim/model/motion.h"
#include "core/sim/step/energies.h"
#include "core/sim/step/energy_account.h"

namespace loomstone {

namespace {

// Returns the largest stretch and strains of the cloth. Collective if `elasticity` is divided among
// ranks.
StrainReport largest_strain(const Engines& engines, Elasticity& elasticity, const Points& x) {
  if (x.rows() == 0) return {};
  Points green;
  Vector stretch;
  elasticity.strain_of_rank(engines.team, x, green, stretch);
  const auto of_rank = [&] {
    std::array<double, 4> largest = {0.0, -1.0, -1.0, 0.0};
    if (stretch.size() > 0) largest[0] = stretch.maxCoeff();
    for (Index t = 0; t < green.rows(); ++t) {
      const Vec3 strain = corotational_strain(Vec3(green.row(t).transpose()));
      largest[1] = std::max(largest[1], strain[0]);
      largest[2] = std::max(largest[2], strain[1]);
      largest[3] = std::max(largest[3], std::abs(strain[2]));
    }
    return largest;
  };
  StrainReport report;
  report.stretch = 0.0, report.weft = report.warp = -1.0;
  const auto add = [&](const std::array<double, 4>& largest) {
    report.stretch = std::max(report.stretch, largest[0]);
    report.weft = std::max(report.weft, largest[1]);
    report.warp = std::max(report.warp, largest[2]);
    report.shear = std::max(report.shear, largest[3]);
  };
  if (!elasticity.divided())
    add(of_rank());
  else
    for (const auto& largest : results_of_ranks(engines.layout.communicator(), of_rank))
      add(largest);
  return report;
}

// Sets the strain and stretch of each triangle, in the user's order, and the largest stretch in the
// report. The positions `x` (n x 3) [m] are in row order.
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
// passed. In each part of the step, vertices move along straight lines, as in certification.
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

void measure(const State& state, double time, const Engines& engines, Measuring how,
             StepReport& report) {
  Elasticity& elasticity = engines.elasticity_for(how);
  measure_energies(state, time, engines, elasticity, report);
  report.strain = largest_strain(engines, elasticity, state.cloth.x);
  report_account(engines.model, state, report);
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
  const double left = std::max(1.0 - at.share, 0.0);
  for (Index vertex = 0; vertex < n; ++vertex) {
    const Index row = model.row_of_vertex[vertex];
    frame.positions.row(vertex) = rows.row(row);
    frame.velocities.row(vertex) = state.cloth.v.row(row);
    if (left > 0.0)
      frame.velocities.row(vertex) +=
          left * (outcome.start.cloth.v.row(row) - state.cloth.v.row(row));
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
