// Fifth stage: strains within their limits, and, the last thing that moves vertices, no impact on
// the way and no intersection at the end. Velocities follow by the mean over the part, (3.16).
#pragma once

#include <optional>

#include "core/sim/step/bisection.h"
#include "core/sim/step/near_contacts.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

struct Certified {
  PartResult result;
  std::optional<LimitReport> limits;  // what limiting left, where nothing has moved since
};

Certified limit_and_certify(const StepContext& part, const Loads& loads, const NearContacts& near,
                            State& state, Engines& engines, StepOutcome& outcome);

}  // namespace loomstone
