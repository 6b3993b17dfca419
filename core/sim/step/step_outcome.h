// Results of a step for reports and frames, and the state at its start, to which a failed step
// returns.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/report.h"
#include "core/cloth/limits/limit_check.h"
#include "core/parallel/communicator.h"
#include "core/sim/model/state.h"

namespace loomstone {

// Positions of all collision vertices at a time within a step.
struct PathPoint {
  double share = 0.0;  // fraction of the step that has passed [1]
  Points vertices;     // (vertices x 3) [m]
};

struct StepOutcome {
  StepReport report;
  SteppedState start;  // state at the start of the step; frames within the step interpolate from it
  std::vector<PathPoint> path;  // ends of all parts but the last; the motion is linear in between
  // (n) For each cloth row: 2 in a triangle of `forced`, 1 in contact in some part of the step,
  // otherwise 0.
  std::vector<std::uint8_t> contact;
  // Limits that are exceeded by more than limit_margin() at the end of the step, with internal
  // triangle indices, in descending order of excess.
  std::vector<BrokenLimit> broken;
  // Pairs of triangles, of which at least one is cloth, that intersect at the end of the step, as
  // indices into the triangles of all surfaces. Set at the end of a step that leaves impacts
  // unresolved, and of the steps after it until no pair intersects or the user sets positions.
  std::vector<std::array<Index, 2>> forced;
};

// StepOutcome::report and StepOutcome::contact before an attempt at a part, for return_to() if the
// part is repeated.
struct OutcomeMark {
  StepReport report;
  std::vector<std::uint8_t> contact;
};

// Clears the results of the previous step, except `start`, and returns them. `step` is the number
// of completed steps.
StepOutcome begin_outcome(std::int64_t step, Index n_vertices, StepOutcome& outcome);
// Restores the results of the previous step, which begin_outcome() returned, after a step that has
// failed. `start` remains the state at the start of the failed step.
void end_failed(StepOutcome previous, StepOutcome& outcome);

inline OutcomeMark mark(const StepOutcome& outcome) { return {outcome.report, outcome.contact}; }

// Times and traffic of a rank in a step.
struct RankWork {
  double wall = 0.0;                                          // wall time [s]
  double collision_computing = 0.0, collision_waiting = 0.0;  // see RankReport [s]
  Traffic traffic;
};

// Returns the times and the traffic of this rank in a step that took the wall time `wall` [s].
// `before` is ranks.traffic() at the start of the step. The times of collision handling are those
// of `report`.
RankWork work_of_step(const Communicator& ranks, const Traffic& before, double wall,
                      const RankReport& report);

// Collective. Summarises the times and the traffic of all ranks in a step.
RankReport summary_of(const Communicator& ranks, const RankWork& own);

// Returns the smallest, mean and largest of the times for which the threads were busy [s].
ThreadReport summary_of(const std::vector<double>& busy);

// Undoes the changes that an attempt made to `outcome`. The report keeps the run times and the
// numbers of iterations of the attempt, and the numbers of evaluations, sweeps, rounds and
// fallbacks of its strain limiting.
void return_to(const OutcomeMark& mark, StepOutcome& outcome);

}  // namespace loomstone
