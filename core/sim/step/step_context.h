// The current step and the current part of it. Stages receive them as arguments and do not store
// them.
#pragma once

#include <cstdint>

namespace loomstone {

struct StepSpan {
  double t0 = 0.0, h = 0.0, t1 = 0.0;  // start, length and end of a step [s]
};

struct StepContext {
  double h = 0.0;   // length of the part [s]
  double t0 = 0.0;  // start of the part [s]
  double t1 = 0.0;  // end of the part [s]
  // Length of the part, divided by the time from its start to the end of the step or, in automatic
  // steps, to the time of the user's targets [1]. The part covers this fraction of the motion to
  // these targets.
  double share = 1.0;
  int length = 0;          // length of the part [1/64 step]
  bool automatic = false;  // true: part of an automatic step
  // Cases in which a failed attempt at the part is repeated in shorter parts.
  bool divisible = true;   // true: repeated if the error of the attempt is too large
  bool halvable = true;    // true: repeated if contacts create energy in the attempt
  std::uint64_t seed = 0;  // seed of random orders; differs between parts and steps
};

}  // namespace loomstone
