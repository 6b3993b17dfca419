// Takes one step, in one or several parts. Each part is a sequence of stages. After a step that
// allows a checkpoint, Model, State and the options determine all later results, so the stepper can
// then be replaced by a new one.
#pragma once

#include "core/parallel/thread_choice.h"
#include "core/sim/step/bisection.h"
#include "core/sim/step/energy_account.h"
#include "core/sim/step/engines.h"
#include "core/sim/step/near_contacts.h"
#include "core/sim/step/step_choice.h"
#include "core/sim/step/step_outcome.h"

namespace loomstone {

class Stepper {
 public:
  // options.step() must be equal to steps.largest, even if steps are automatic.
  Stepper(const Model& model, const IntegratorOptions& options, StepChoice steps,
          const Workers& workers, const State& state);

  // Advances `state` by one step. If the step fails, restores the state at the start of the step
  // and throws SolverFailure.
  void advance(State& state, StepOutcome& outcome);

  Engines& engines() { return engines_; }
  // Memory of the data of a step and, separately, of its contacts and terms [bytes].
  std::size_t step_bytes() const;
  std::size_t contact_bytes() const;

 private:
  PartResult run_stages(const StepContext& part, State& state, StepOutcome& outcome);
  template <class Stage>
  void collide(double& seconds, StepReport& report, Stage&& stage);
  void finish(const StepSpan& span, State& state, StepOutcome& outcome);

  StepChoice steps_;
  Engines engines_;
  ThreadChoice threads_;
  // Scratch data that one stage writes and later stages read.
  Loads loads_;
  NearContacts near_;
  Solved solved_;
};

}  // namespace loomstone
