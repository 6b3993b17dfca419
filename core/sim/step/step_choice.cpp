#include "core/sim/step/step_choice.h"

#include <algorithm>
#include <cmath>

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
// Automatic step of explicit schemes, as a fraction of the stable step at the start. Our choice:
// stretched cloth is stiffer than cloth at the start.
constexpr double share_of_stable = 0.5;
// Longest part of an automatic step of explicit schemes, as a fraction of the step at which the
// stretched cloth is stable. Our choice: steps are then divided only if cloth is stretched to more
// than about 1.58 times its length. With 0.7, cloth at a stretch of 1.3 changes between two lengths
// and gains energy.
constexpr double share_when_stretched = 0.9;

}  // namespace

StepChoice choose_steps(const IntegratorOptions& options, const Model& model, const State& state) {
  const Automatic step = options.step();
  if (step.given) return {*step.given, false};
  if (options.is<Asynchronous>()) return {Asynchronous::default_step, false};
  const bool euler = options.is<SemiImplicitEuler>() || options.is<BackwardEuler>();
  const double largest = euler && model.n_bodies() == 0 ? largest_of_euler : largest_otherwise;
  const ImplicitOptions* implicit = options.implicit();
  if (!implicit) {
    const double stable = stable_step(model.cloth, state.cloth.x);
    return {std::min(largest, share_of_stable * stable), false, stable};
  }
  require(implicit->accuracy.has_value(),
          "integrator.accuracy must be a number if integrator.step is \"auto\"; set an accuracy "
          "or a step [s]");
  return {largest, true};
}

int stable_part(const StepContext& part, const StepChoice& steps, const Points& x,
                const Engines& engines) {
  const auto largest_stretch = [&] {
    Points green;
    Vector stretch;
    engines.elasticity->strain(engines.team, x, green, stretch);
    return stretch.size() > 0 ? stretch.maxCoeff() : 1.0;
  };
  double stretch = 1.0;
  for (const double of_rank : results_of_ranks(engines.layout.communicator(), largest_stretch))
    stretch = std::max(stretch, of_rank);
  const double stiffening = 0.5 * (3.0 * stretch * stretch - 1.0);
  const double h = share_when_stretched * steps.stable / std::sqrt(stiffening);
  return std::max(static_cast<int>(std::min(h / part.h, 1.0) * part.length), int{StepPart::least});
}

}  // namespace loomstone
