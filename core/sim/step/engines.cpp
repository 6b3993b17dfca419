#include "core/sim/step/engines.h"

#include <algorithm>
#include <vector>

#include "core/parallel/shared_work.h"
#include "core/sim/model/motion.h"

namespace loomstone {

namespace {

std::unique_ptr<RigidWorld> make_world(const Model& model, const State& state, double time,
                                       bool contacts_only) {
  const Vec3 gravity = contacts_only ? Vec3(Vec3::Zero()) : model.scene.gravity;
  auto world = std::make_unique<RigidWorld>(model.scene.bodies, rigid_obstacles(model, state, time),
                                            gravity, !contacts_only, model.scene.rigid_iterations,
                                            model.magnetics.bearing_axes());
  world->restore(state.rigid);
  return world;
}

LimitedCloth limited_cloth(const ClothModel& cloth) {
  return {cloth.n_vertices,      cloth.triangles, cloth.corners.all(), cloth.strain_limits,
          cloth.strain_limit_of, cloth.mass,      cloth.prescribed};
}

}  // namespace

Engines::Engines(const Model& model, const IntegratorOptions& options, const Workers& workers,
                 const State& state)
    : model(model),
      layout(workers.layout),
      team(workers.team),
      busy(team.threads, 0.0),
      collision_team(team) {
  collision_team.busy = busy.data();
  const BendingTreatment bending = bending_treatment(options, model.cloth);
  // In asynchronous steps, every rank evaluates the elements of all triangles.
  elasticity = options.is<Asynchronous>()
                   ? std::make_unique<Elasticity>(model.cloth, bending)
                   : std::make_unique<Elasticity>(model.cloth, bending, layout);
  integrator = make_integrator(options, model.cloth, *elasticity);
  if (model.scene.collisions && model.cloth.n_vertices > 0)
    collision = std::make_unique<CollisionStage>(model.collision, workers.decomposition,
                                                 layout.shared_communicator());
  if (collision && integrator->events_collide())
    event_contacts =
        std::make_unique<EventContacts>(model.collision, collision->pairs(), model.inverse_mass);
  if (model.n_bodies() > 0) {
    if (model.magnetics.acts()) magnetics = std::make_unique<MagneticMotion>(model.magnetics);
    // If MagneticMotion or the integrator moves the bodies, it applies gravity and gyroscopic
    // torques, so the world must not apply them again.
    const bool moved = integrator->moves_bodies() && model.cloth.n_vertices > 0;
    world = make_world(model, state, state.time, magnetics != nullptr || moved);
  }
  if (!model.cloth.strain_limits.empty())
    limiter = std::make_unique<StrainLimiter>(limited_cloth(model.cloth), model.scene.limits,
                                              &layout.communicator());
  recovery_rate = loomstone::recovery_rate(model.cloth);
  if (const ImplicitOptions* implicit = options.implicit()) accuracy = implicit->accuracy;
  if (accuracy && model.cloth.n_vertices > 0)
    error = std::make_unique<DisplacementError>(model.cloth, *elasticity,
                                                model.scene.gravity.norm(), layout);
  contacts_in_solve = integrator->implicit() && model.scene.response == ContactResponse::Implicit;
  if (collision && contacts_in_solve && !layout.single() && !integrator->needs_all_terms())
    collision->divide({layout.begin(), layout.end()});
  limits_after_solve = !options.is<Asynchronous>();
  limits_in_solve = integrator->implicit() && model.scene.limits.in_solve &&
                    model.scene.limits.method != LimitMethod::Edges;
}

bool Engines::at_limits() const {
  if (!limits_in_solve || !limiter) return false;
  const std::vector<char> on_ranks = results_of_ranks(
      layout.communicator(), [&]() -> char { return elasticity->in_limit_phase(); });
  return std::find(on_ranks.begin(), on_ranks.end(), 1) != on_ranks.end();
}

Elasticity& Engines::elasticity_for(Measuring how) const {
  if (how == Measuring::Together || !elasticity->divided()) return *elasticity;
  if (!all_elements) all_elements = elasticity->whole();
  return *all_elements;
}

}  // namespace loomstone
