// Engines that the stages of a step use: the mechanics of cloth, bodies, magnets and contacts. They
// are built from the model, the options and the state. If they are rebuilt after a step that allows
// a checkpoint, later results are bitwise identical to those of the old engines.
#pragma once

#include <memory>
#include <optional>

#include "core/cloth/displacement_error.h"
#include "core/cloth/elasticity.h"
#include "core/cloth/limits/strain_limiter.h"
#include "core/collision/collision_stage.h"
#include "core/collision/event_contacts.h"
#include "core/electrodynamics/magnetic_motion.h"
#include "core/integration/integrator.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"
#include "core/rigid/rigid_body.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// The threads and ranks of a simulation.
struct Workers {
  Team team;
  const RowLayout& layout;
  Decomposition decomposition = Decomposition::Predicted;
};

// How ranks measure energies and strains. Together: all ranks take part, and each evaluates its own
// elements. Alone: this rank evaluates all elements without the others.
enum class Measuring { Together, Alone };

struct Engines {
  Engines(const Model& model, const IntegratorOptions& options, const Workers& workers,
          const State& state);

  const Model& model;
  const RowLayout& layout;
  Team team;
  std::vector<double> busy;  // (threads) time of each thread in collision loops of this step [s]
  Team collision_team;       // the threads of `team`; their time is added to `busy`
  std::unique_ptr<Elasticity> elasticity;  // elements of this rank or, in asynchronous steps, all
  // Elements of all ranks; null until this rank first measures alone, and always if `elasticity` is
  // not divided among ranks.
  mutable std::unique_ptr<Elasticity> all_elements;
  Elasticity& elasticity_for(Measuring how) const;
  std::unique_ptr<Integrator> integrator;
  std::unique_ptr<CollisionStage> collision;  // null: no cloth, or Scene::collisions is false
  // Energy of contacts at the end of the latest attempt at a part, stored for the report of the
  // step; empty if energy_at_end() has not been called in this attempt.
  struct ContactEnergy {
    double time;           // [s]
    std::uint8_t tangled;  // State::tangled
    double energy;         // [J]
  };
  mutable std::optional<ContactEnergy> contact_energy;
  // Null: the integrator does not handle collisions at events, or `collision` is null.
  std::unique_ptr<EventContacts> event_contacts;
  std::unique_ptr<RigidWorld> world;  // null: no bodies
  // Null: no bodies, or neither magnets nor coils nor bearings.
  std::unique_ptr<MagneticMotion> magnetics;
  std::unique_ptr<StrainLimiter> limiter;    // null: no cloth has limits
  std::optional<double> accuracy;            // ImplicitOptions::accuracy [1]; null: none
  std::unique_ptr<DisplacementError> error;  // null: no accuracy or no cloth
  // False: impulses resolve contacts, after the solve or at events.
  bool contacts_in_solve = false;
  // False: limiting is left to the integrator, and `limiter` only measures the excess.
  bool limits_after_solve = true;
  bool limits_in_solve = false;  // true: the implicit solve includes strain limits
  double recovery_rate = 0.0;    // see loomstone::recovery_rate() [1/s]

  // Collective. Returns whether any triangle of any rank is in a limit phase. The phases are those
  // in the solve of the current part, or those at its end if energy_at_end() has found them.
  bool at_limits() const;
};

}  // namespace loomstone
