// Error of a part of a step: the strain that the linear model of implicit integrators neglects over
// the motion of the part.
#pragma once

#include "core/base/report.h"
#include "core/sim/step/loads.h"

namespace loomstone {

// The larger of the two parts of an error, each as a fraction of its tolerance [1].
double relative_error(const StepError& error);

// Returns the error over the motion of cloth from the start of the part to its present positions.
StepError error_of_motion(const StepContext& part, const Loads& loads, const State& state,
                          Engines& engines);

// Returns whether the error of an attempt is too large and the part can be divided.
bool must_divide(const StepContext& part, const StepError& error, const Engines& engines);

// Returns whether the part must be divided before its solve, because the motion with unchanged
// velocities would have too large an error.
bool expects_error(const StepContext& part, const State& state, Engines& engines);

// Adds the error of an accepted part to the report.
void note_error(const StepContext& part, const StepError& error, const Engines& engines,
                StepReport& report);

}  // namespace loomstone
