#include "core/sim/step/step_choice.h"

#include "core/base/message.h"
#include "core/integration/stable_step.h"

namespace loomstone {

namespace {

// Our choice: with longer steps, implicit Euler damps free motion visibly.
constexpr double largest_of_cloth = 10e-3;
// Our choice: the error of cloth says nothing about the contacts of rigid bodies, which sink in and
// bounce in longer steps.
constexpr double largest_of_bodies = 1e-3;
constexpr double share_of_stable = 0.5;  // stretched cloth is stiffer than at the start

}  // namespace

StepChoice choose_steps(const IntegratorOptions& options, const Model& model, const State& state) {
  const Automatic step = options.step();
  if (step.given) return {*step.given, false};
  double largest = model.n_bodies() > 0 ? largest_of_bodies : largest_of_cloth;
  const ImplicitOptions* implicit = options.implicit();
  if (!implicit)
    return {std::min(largest, share_of_stable * stable_step(model.cloth, state.cloth.x)), false};
  require(implicit->accuracy.has_value(),
          "integrator.accuracy must be a number if integrator.step is \"auto\"; set an accuracy "
          "or a step [s]");
  return {largest, true};
}

}  // namespace loomstone
