// Third stage of a part of a step: the integrator advances the cloth. An implicit solve includes
// contacts, strain limits and attachments.
#pragma once

#include "core/sim/step/near_contacts.h"

namespace loomstone {

// Advances the cloth of `state`. Returns the velocities of the bodies (2 b x 3) after the cloth has
// acted on them; without cloth, these are the velocities predicted in `loads`. Throws
// SolverFailure.
Points integrate(const StepContext& part, const Loads& loads, NearContacts& near, State& state,
                 Engines& engines, StepReport& report);

}  // namespace loomstone
