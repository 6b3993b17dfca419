// Error of a part of a step, and the lengths of parts and of automatic steps that it allows. The
// error is the strain that the linear model of an implicit integrator neglects in the motion of the
// part, and the energy of this strain (see StepError).
#pragma once

#include "core/base/report.h"
#include "core/sim/step/bisection.h"
#include "core/sim/step/loads.h"
#include "core/sim/step/near_contacts.h"

namespace loomstone {

// Returns the error of the motion of cloth from the start of the part to the positions in `state`.
StepError error_of_motion(const StepContext& part, const Loads& loads, const State& state,
                          Engines& engines);

// Returns whether the error of an attempt is too large and the part can be shortened.
bool too_large(const StepContext& part, const StepError& error, const Engines& engines);

// Returns the result of an attempt at a part whose error is too large. The result contains the
// length that the error allows.
PartResult shorter(const StepContext& part, const StepError& error, const Engines& engines);

// Returns the length that error, damping and drag are expected to allow for the next part of a step
// that is not automatic, in 64ths of the step (see StepPart). `part` is this next part as planned,
// and the result is at most its length. Error and damping are those of the previous part. If these
// are unknown (ClothState::expected_step is 0), the error is that of a motion at the current
// velocities, and damping is ignored.
int expected_part(const StepContext& part, const State& state, Engines& engines);

// Stores in `cloth` the length that `error`, the error of `part`, allows for the next part. In
// steps of given length, the damping of implicit Euler limits it too.
void expect_part(const StepContext& part, const StepError& error, const Engines& engines,
                 ClothState& cloth);

// Returns the length of the next automatic step, between `largest` / 64 and `largest` [s]. Drag can
// shorten it to `largest` / 4096.
double automatic_step(double largest, const State& state, Engines& engines);

// After an automatic step of length h [s] from `start`, limits the length of the next one by the
// damping of implicit Euler, by the allowed growth and, if strain limits were forced
// (NearContacts::forced), by a fraction of `largest`.
void expect_step(double largest, const SteppedState& start, double h, const NearContacts& near,
                 Engines& engines, State& state);

// Records the error and the length of a part in the report.
void note_error(const StepContext& part, const StepError& error, const Engines& engines,
                StepReport& report);

}  // namespace loomstone
