#include "core/sim/step/loads.h"

#include <algorithm>

#include "core/cloth/air.h"
#include "core/electrodynamics/coil_currents.h"
#include "core/sim/model/motion.h"

namespace loomstone {

namespace {

// Adds to `velocity` (2 b x 3) the changes that loads.body_impulse causes.
void add_body_impulses(const Loads& loads, Points& velocity) {
  for (Index row = 0; row < velocity.rows(); ++row) {
    if (loads.body_impulse.row(row).isZero(0.0)) continue;
    velocity.row(row) +=
        (loads.body_mass[row].inverse() * loads.body_impulse.row(row).transpose()).transpose();
  }
}

// Predicts the velocities of bodies under gravity, the user's forces and, if there is cloth,
// magnetic forces, so that the solve adds only the effect of the cloth.
void predict_bodies(const StepContext& part, const State& state, const Engines& engines,
                    Loads& loads) {
  const Model& model = engines.model;
  loads.body_mass.clear();
  loads.body_poses.clear();
  loads.body_velocity = Points::Zero(2 * model.n_bodies(), 3);
  loads.body_angular_velocity = state.rigid.angular_velocities;
  loads.body_impulse = Points::Zero(2 * model.n_bodies(), 3);
  std::vector<Wrench> magnetic(model.n_bodies());
  if (engines.magnetics && model.cloth.n_vertices > 0)
    magnetic = engines.magnetics->wrenches(
        engines.team, {state.rigid, obstacle_places(model, state, part.t0, 0.0).poses},
        coil_currents(model.magnetics, state.magnetic.circuits, part.t0));
  for (Index b = 0; b < model.n_bodies(); ++b) {
    const double mass = model.body_mass[b].mass;
    const Mat3 inertia =
        world_inertia(model.body_mass[b], state.rigid.orientations.row(b).transpose());
    loads.body_poses.push_back(body_pose(state.rigid, b));
    loads.body_mass.push_back(mass * Mat3::Identity());
    loads.body_mass.push_back(inertia);
    loads.body_velocity.row(2 * b) = state.rigid.velocities.row(b) +
                                     part.h * model.scene.gravity.transpose() +
                                     part.h / mass * magnetic[b].force.transpose();
    loads.body_velocity.row(2 * b + 1) =
        state.rigid.angular_velocities.row(b) +
        part.h * (inertia.inverse() * magnetic[b].torque).transpose();
    loads.body_impulse.row(2 * b) = part.h * state.body_force.row(b);
    loads.body_impulse.row(2 * b + 1) = part.h * state.body_torque.row(b);
  }
  add_body_impulses(loads, loads.body_velocity);
}

}  // namespace

Rows own_cloth_rows(const Engines& engines) {
  const Index n = engines.model.cloth.n_vertices;
  return {std::min(engines.layout.begin(), n), std::min(engines.layout.end(), n)};
}

void find_cloth_forces(double time, const State& state, const Engines& engines, Rows rows,
                       RowsOut force) {
  const Model& model = engines.model;
  const Points& given = state.external_force;
  parallel_for(engines.team, rows.end - rows.begin, [&](Index i) {
    const Index row = rows.begin + i;
    if (given.rows() > 0)
      force.row(row) = given.row(row);
    else
      force.row(row).setZero();
    force.row(row) += model.cloth.mass[row] * model.scene.gravity.transpose();
  });
  const DraggedSurface surface{time, model.cloth.triangles, model.cloth.triangles_of_vertex,
                               state.cloth.x, state.cloth.v};
  add_drag(engines.team, model.scene.air, surface, rows.begin, rows.end, force);
}

bool pins_move(const ClothModel& cloth, const Loads& loads) {
  for (Index i = 0; i < static_cast<Index>(loads.target.rows()); ++i)
    if (cloth.prescribed[i] && loads.target.row(i) != loads.x0.row(i)) return true;
  return false;
}

void find_loads(const StepContext& part, const State& state, const Engines& engines, Loads& loads) {
  const Model& model = engines.model;
  if (model.cloth.n_vertices > 0) collision_vertices(model, state, loads.x0);
  const std::vector<std::uint8_t>& pinned = model.cloth.prescribed;
  if (std::find(pinned.begin(), pinned.end(), 1) != pinned.end()) {
    loads.v0 = state.cloth.v;
    pin_targets(model, state, part.t1, part.share, loads.target);
  }
  obstacle_vertices(model, state, part.t1, part.share, loads.next_obstacles);
  const Rows own = own_cloth_rows(engines);
  loads.force.resize(own.begin, own.end);
  find_cloth_forces(part.t0, state, engines, own, loads.force);
  predict_bodies(part, state, engines, loads);
}

}  // namespace loomstone
