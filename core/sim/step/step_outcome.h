// The outcome of a step for people to look at. Nothing here decides what follows, but for `start`,
// to which a failed step returns.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/report.h"
#include "core/cloth/limits/limit_check.h"
#include "core/sim/model/state.h"

namespace loomstone {

struct StepOutcome {
  StepReport report;
  State start;  // of the step: a failed step returns to it, frames within the step begin at it
  std::vector<std::uint8_t>
      contact;  // (n) rows: 1 in contact, 2 in a triangle that is forced to intersect
  std::vector<BrokenLimit> broken;  // triangles in the internal order, the largest excess first
  std::vector<std::array<Index, 2>>
      forced;  // pairs of triangles (all surfaces) that are forced to intersect
};

// The outcome before an attempt at a part, to which a failed attempt returns.
struct OutcomeMark {
  StepReport report;
  std::vector<std::uint8_t> contact;
};

// Empties all but `start` for the step that follows the given one.
void begin_outcome(std::int64_t step, double step_length, Index n_vertices, StepOutcome& outcome);

inline OutcomeMark mark(const StepOutcome& outcome) { return {outcome.report, outcome.contact}; }

// Takes an attempt back. The time and the iterations that it took stay in the report.
void return_to(const OutcomeMark& mark, StepOutcome& outcome);

}  // namespace loomstone
