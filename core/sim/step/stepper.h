// One step: a row of stages. Everything here may be thrown away between two steps; only State
// carries on.
#pragma once

#include "core/sim/step/bisection.h"
#include "core/sim/step/engines.h"
#include "core/sim/step/near_contacts.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

class Stepper {
 public:
  Stepper(const Model& model, const IntegratorOptions& options, const Team& team,
          const RowLayout& layout, const State& state);

  // Advances `state` by one step. Throws SolverFailure; `state` is then that of the start of the
  // step.
  void advance(State& state, StepOutcome& outcome);

  Engines& engines() { return engines_; }

 private:
  void take_parts(State& state, StepOutcome& outcome);
  PartResult attempt(StepPart part, State& state, StepOutcome& outcome);
  PartResult run_stages(const StepContext& part, State& state, StepOutcome& outcome);
  void finish(State& state, StepOutcome& outcome);
  StepContext context(StepPart part, std::int64_t step) const;
  void save_to(State& snapshot) const;  // what the rigid-body world carries on
  void return_to_state(const State& snapshot, State& state);  // of engines, too

  double step_;  // [s]
  Engines engines_;
  // Scratch that one stage writes and the next ones read.
  Loads loads_;
  NearContacts near_;
};

}  // namespace loomstone
