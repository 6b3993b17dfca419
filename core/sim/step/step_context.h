// The current part of a step. Stages receive it as an argument and do not store it.
#pragma once

#include <cstdint>

namespace loomstone {

struct StepContext {
  double h = 0.0;   // length of the part [s]
  double t0 = 0.0;  // its start [s]
  double t1 = 0.0;  // its end [s]
  // Length of the part divided by the length of the step that remains at the start of the part [1].
  // The part covers this fraction of the motion to the user's targets.
  double share = 1.0;
  bool divisible = true;   // a failed attempt can be repeated in two halves
  std::uint64_t seed = 0;  // seed of random orders; differs between parts and steps
};

}  // namespace loomstone
