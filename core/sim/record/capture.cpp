#include "core/sim/record/capture.h"

#include <algorithm>
#include <cmath>

#include "core/cloth/limits/strain_limiter.h"
#include "core/sim/currents.h"
#include "core/sim/model/motion.h"

namespace loomstone {

void measure(const Model& model, const State& state, const Team& team, Elasticity& elasticity,
             StepReport& report) {
  const Index n = model.cloth.n_vertices;
  const Points &x = state.cloth.x, &v = state.cloth.v;
  const Vector& mass = model.cloth.mass;
  report.energy.kinetic =
      parallel_sum(team, n, [&](Index i) { return 0.5 * mass[i] * v.row(i).squaredNorm(); });
  report.energy.gravity = -parallel_sum(
      team, n, [&](Index i) { return mass[i] * x.row(i).dot(model.scene.gravity.transpose()); });
  report.energy.body_kinetic = report.energy.body_gravity = 0.0;
  for (Index b = 0; b < model.n_bodies(); ++b) {
    const double body_mass = model.body_mass[b].mass;
    const Vec3 spin = state.rigid.angular_velocities.row(b).transpose();
    const Mat3 inertia =
        world_inertia(model.body_mass[b], state.rigid.orientations.row(b).transpose());
    report.energy.body_kinetic +=
        0.5 * (body_mass * state.rigid.velocities.row(b).squaredNorm() + spin.dot(inertia * spin));
    report.energy.body_gravity -=
        body_mass * state.rigid.positions.row(b).dot(model.scene.gravity.transpose());
  }
  report.circuits.current = first_circuit_current(model, state);
  report.circuits.energy = state.circuits.energy;
  report.circuits.heat = state.circuits.heat, report.circuits.supply = state.circuits.supply;
  report.circuits.bearing_work = state.circuits.bearings;
  report.strain.stretch = 1.0;
  report.strain.weft = report.strain.warp = report.strain.shear = 0.0;
  if (n == 0) return;
  report.energy.membrane = elasticity.membrane_energy(team, x);
  report.energy.bending = elasticity.bending_energy(team, x);
  Points green;
  Vector stretch;
  elasticity.strain(team, x, green, stretch);
  report.strain.stretch = stretch.maxCoeff();
  report.strain.weft = report.strain.warp = -1.0;
  for (Index t = 0; t < green.rows(); ++t) {
    const Vec3 strain = corotational_strain(Vec3(green.row(t).transpose()));
    report.strain.weft = std::max(report.strain.weft, strain[0]);
    report.strain.warp = std::max(report.strain.warp, strain[1]);
    report.strain.shear = std::max(report.strain.shear, std::abs(strain[2]));
  }
}

Frame capture(const Model& model, const State& state, const StepOutcome& outcome, const Team& team,
              Elasticity& elasticity, double step, double share) {
  const Index n = model.cloth.n_vertices, m = static_cast<Index>(model.cloth.triangles.rows());
  Frame frame;
  frame.step = state.step;
  frame.time = (static_cast<double>(state.step) - (1.0 - share)) * step;
  frame.report = outcome.report;
  frame.coil_currents = coil_currents(model, state, frame.time);
  Points vertices;
  collision_vertices(model, state, vertices);
  if (share < 1.0) {
    Points start;
    collision_vertices(model, outcome.start, start);
    vertices = start + share * (vertices - start);
  }
  const Points rows = vertices.topRows(n);
  frame.body_positions = vertices.bottomRows(vertices.rows() - n);
  frame.positions.resize(n, 3);
  frame.velocities.resize(n, 3);
  frame.contact.assign(n, 0);
  for (Index vertex = 0; vertex < n; ++vertex) {
    const Index row = model.row_of_vertex[vertex];
    frame.positions.row(vertex) = rows.row(row);
    frame.velocities.row(vertex) = state.cloth.v.row(row);
    if (!outcome.contact.empty()) frame.contact[vertex] = outcome.contact[row];
  }
  frame.strain.resize(m, 3);
  frame.stretch.resize(m);
  if (m == 0) return frame;
  Points green;
  Vector stretch;
  elasticity.strain(team, rows, green, stretch);
  for (Index t = 0; t < m; ++t) {
    frame.strain.row(model.triangle_of[t]) = green.row(t);
    frame.stretch[model.triangle_of[t]] = stretch[t];
  }
  frame.report.strain.stretch = stretch.maxCoeff();
  return frame;
}

std::vector<Wrench> magnetic_forces(const Model& model, const State& state, double time,
                                    const Engines& engines) {
  if (!engines.magnetics) return std::vector<Wrench>(model.n_bodies());
  return engines.magnetics->wrenches(engines.team, state.rigid,
                                     obstacle_places(model, state, time, 0.0).poses,
                                     coil_currents(model, state, time));
}

double magnetic_energy(const Model& model, const State& state, double time,
                       const Engines& engines) {
  if (!engines.magnetics) return 0.0;
  return engines.magnetics->energy(engines.team, state.rigid,
                                   obstacle_places(model, state, time, 0.0).poses,
                                   state.induced_moments);
}

}  // namespace loomstone
