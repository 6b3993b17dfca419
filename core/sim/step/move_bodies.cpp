#include "core/sim/step/move_bodies.h"

#include "core/sim/model/motion.h"

namespace loomstone {

double move_bodies(const StepContext& part, const Loads& loads, const Points& body_velocity,
                   State& state, Engines& engines, StepReport& report) {
  if (!engines.world) return 0.0;
  const Model& model = engines.model;
  Points impulses = Points::Zero(model.n_bodies(), 3), angular = impulses;
  if (model.cloth.n_vertices > 0)
    for (Index b = 0; b < model.n_bodies(); ++b) {
      impulses.row(b) =
          model.body_mass[b].mass * (body_velocity.row(2 * b) - loads.body_velocity.row(2 * b));
      angular.row(b) =
          (loads.body_mass[2 * b + 1] *
           (body_velocity.row(2 * b + 1) - loads.body_velocity.row(2 * b + 1)).transpose())
              .transpose();
    }
  const ObstaclePlaces places = obstacle_places(model, state, part.t1, part.share);
  if (!engines.magnetics) {
    engines.world->advance(part.h, impulses, angular, places, state.rigid);
    return engines.world->obstacle_work();
  }
  const ObstaclePlaces start = obstacle_places(model, state, part.t0, 0.0);
  const MagneticEffort effort =
      engines.magnetics->advance(engines.team, {part.t0, part.h, impulses, angular, start, places},
                                 *engines.world, state.rigid, state.magnetic);
  report.magnets.substeps += effort.substeps;
  report.magnets.force_error = effort.error;
  return effort.obstacle_work;
}

}  // namespace loomstone
