// Third stage of a part of a step: the integrator advances the cloth. An implicit solve includes
// attachments and, depending on the options, contacts and strain limits. If it includes contacts,
// it also includes untangling.
#pragma once

#include "core/sim/step/near_contacts.h"

namespace loomstone {

struct SolvedBodies {
  // (2 b x 3) velocities of the bodies after the impulses of the cloth, or the predicted velocities
  // if there is no cloth [m/s, rad/s]
  Points velocity;
  // (b) Poses of the bodies at the end of the part, and BodiesOfStep::with_cloth. Both are empty
  // unless the integrator moves bodies.
  std::vector<RigidPose> poses = {};
  std::vector<std::uint8_t> with_cloth = {};
};

// Advances the cloth of `state`. Returns the solved motion of the bodies. Throws SolverFailure if
// the integrator fails.
SolvedBodies integrate(const StepContext& part, const Loads& loads, NearContacts& near,
                       State& state, Engines& engines, StepReport& report);

}  // namespace loomstone
