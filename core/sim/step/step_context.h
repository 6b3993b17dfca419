// The part of a step that is being taken. Every stage is given it; none remembers it.
#pragma once

#include <cstdint>

namespace loomstone {

struct StepContext {
  double h = 0.0;   // length of the part [s]
  double t0 = 0.0;  // its start [s]
  double t1 = 0.0;  // its end [s]
  double share =
      1.0;  // its share of what was left of the step: how far scripted targets are approached [1]
  std::uint64_t seed = 0;  // of random orders; differs from part to part and from step to step
};

}  // namespace loomstone
