// Third stage: cloth advances by the integrator, with contacts, limits and attachments inside its
// solve where it has one.
#pragma once

#include "core/sim/step/near_contacts.h"

namespace loomstone {

// Advances the cloth of `state`. Returns the velocities of the bodies after what the cloth does to
// them: (2 b x 3), those of `loads` where there is no cloth. Throws SolverFailure.
Points integrate(const StepContext& part, const Loads& loads, NearContacts& near, State& state,
                 Engines& engines, StepReport& report);

}  // namespace loomstone
