// Fifth stage: moves the obstacles and enforces strain limits (not in asynchronous steps). Then
// untangles surfaces by impulses, if the solve does not include contacts, and also resolves the
// contacts by impulses, unless this has been done at events. Finally corrects the motion so that it
// has no impact and ends without new intersections. Impacts that remain are counted. No later stage
// moves vertices. Velocities change by the corrections divided by the length of the part, as in
// (3.16) of [Thomaszewski2010], except for the corrections ConstrainReport::at_rest. Also updates
// the friction anchors of contacts in the solve.
#pragma once

#include <optional>

#include "core/sim/step/bisection.h"
#include "core/sim/step/near_contacts.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

struct Certified {
  PartResult result;
  bool moved = false;  // this stage moved cloth
  // (n x 3) Positions [m] and velocities [m/s] of cloth before this stage; no rows unless `moved`.
  Points solved_x, solved_v;
  double limited = 0.0;  // energy that limiting removed from cloth [J]
  // Report of the limiting; empty if there was none or if vertices may have moved since.
  std::optional<LimitReport> limits;
};

Certified limit_and_certify(const StepContext& part, const Loads& loads, NearContacts& near,
                            State& state, Engines& engines, StepOutcome& outcome);

}  // namespace loomstone
