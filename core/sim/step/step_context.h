// The current step and the current part of it. Stages receive them as arguments and do not store
// them.
#pragma once

#include <cstdint>

namespace loomstone {

struct SteppedState;

struct StepSpan {
  double t0 = 0.0, h = 0.0, t1 = 0.0;  // start, length and end of a step [s]
};

struct StepContext {
  double h = 0.0;   // length of the part [s]
  double t0 = 0.0;  // start of the part [s]
  double t1 = 0.0;  // end of the part [s]
  // Fraction of the remaining motion to the user's targets that the part covers [1]. It is the
  // length of the part divided by the remaining time, but at most 1. The remaining time ends with
  // the step or, in automatic steps, at the time of the targets.
  double share = 1.0;
  int length = 0;          // length of the part [1/64 step]
  bool automatic = false;  // true: part of an automatic step
  // Cases in which an attempt at the part is repeated with a shorter length; `saves_work` has an
  // effect only in implicit Euler schemes.
  bool divisible = true;   // true: repeated if the error of the attempt is too large
  bool halvable = true;    // true: repeated if it creates too much energy (implicit schemes)
  bool saves_work = true;  // true: repeated if it loses too much of the work of scripts
  std::uint64_t seed = 0;  // seed of random orders; differs between parts and steps
  const SteppedState* start = nullptr;  // state at the start of the part
};

}  // namespace loomstone
