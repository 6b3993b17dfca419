#include "core/sim/step/step_choice.h"

#include <algorithm>

#include "core/base/message.h"
#include "core/integration/stable_step.h"

namespace loomstone {

namespace {

// Largest step of the implicit Euler schemes [s]. Our choice: longer steps visibly damp free
// motion.
constexpr double largest_of_euler = 10e-3;
// Largest step of all other schemes except the asynchronous one, and, in scenes with bodies, also
// of the implicit Euler schemes [s]. Our choice: the error of the membrane, which shortens steps,
// says nothing about contacts. In contacts that a step does not resolve, schemes without damping
// throw cloth back, and bodies sink in and bounce.
constexpr double largest_otherwise = 1e-3;
// Largest step of explicit schemes, as a fraction of the stable step at the start. Our choice:
// stretched cloth is stiffer than cloth at the start.
constexpr double share_of_stable = 0.5;

}  // namespace

StepChoice choose_steps(const IntegratorOptions& options, const Model& model, const State& state) {
  const Automatic step = options.step();
  if (step.given) return {*step.given, false};
  if (options.is<Asynchronous>()) return {Asynchronous::default_step, false};
  const bool euler = options.is<SemiImplicitEuler>() || options.is<BackwardEuler>();
  const double largest = euler && model.n_bodies() == 0 ? largest_of_euler : largest_otherwise;
  const ImplicitOptions* implicit = options.implicit();
  if (!implicit)
    return {std::min(largest, share_of_stable * stable_step(model.cloth, state.cloth.x)), false};
  require(implicit->accuracy.has_value(),
          "integrator.accuracy must be a number if integrator.step is \"auto\"; set an accuracy "
          "or a step [s]");
  return {largest, true};
}

}  // namespace loomstone
