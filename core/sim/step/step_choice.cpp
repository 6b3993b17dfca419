#include "core/sim/step/step_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/message.h"
#include "core/integration/stable_step.h"
#include "core/parallel/shared_work.h"
#include "core/sim/step/bisection.h"

namespace loomstone {

namespace {

// Largest automatic step of the implicit Euler schemes in scenes without bodies [s]. Our choice:
// longer steps visibly damp free motion.
constexpr double largest_of_euler = 10e-3;
// Largest automatic step of all other schemes except the asynchronous one [s]. In scenes with
// bodies, it also applies to the implicit Euler schemes. Our choice: the error of the membrane,
// which shortens steps, says nothing about contacts. In contacts that a step does not resolve,
// schemes without damping throw cloth back, and bodies sink in and bounce.
constexpr double largest_otherwise = 1e-3;
// Automatic step of explicit schemes, as a fraction of the longest stable step at the start. The
// step is at most largest_otherwise. Our choice: stretched cloth is stiffer than cloth at the
// start.
constexpr double share_of_stable = 0.5;
// Longest part of an automatic step of explicit schemes, as a fraction of the longest step at which
// the stretched cloth is stable. Our choice: steps are then divided only if cloth is stretched to
// more than about 1.58 times its length. With 0.7, the parts of steps alternate between two lengths
// at a stretch of 1.3, and the cloth gains energy.
constexpr double share_when_stretched = 0.9;
// Number of steps after which the stretch is measured again. Our choice: a measurement takes up to
// a third of the time of a step, and in this number of stable steps, a wave of stretch crosses few
// triangles.
constexpr std::int64_t steps_per_measurement = 8;

}  // namespace

StepChoice choose_steps(const IntegratorOptions& options, const Model& model, const State& state) {
  const Automatic step = options.step();
  if (step.given) return {*step.given, false};
  if (options.is<Asynchronous>()) return {Asynchronous::default_step, false};
  const bool euler = options.is<SemiImplicitEuler>() || options.is<BackwardEuler>();
  const double largest = euler && model.n_bodies() == 0 ? largest_of_euler : largest_otherwise;
  const ImplicitOptions* implicit = options.implicit();
  if (!implicit) {
    Elasticity elasticity(model.cloth, BendingTreatment::Explicit);
    const double stable = stable_step(elasticity, model.cloth, state.cloth.x);
    return {std::min(largest, share_of_stable * stable), false,
            stable * std::sqrt(stiffening_of_rank(elasticity, {}, state.cloth.x))};
  }
  require(implicit->accuracy.has_value(),
          "integrator.accuracy must be a number if integrator.step is \"auto\"; set an accuracy "
          "or a step [s]");
  return {largest, true};
}

int stable_part(const StepContext& part, const StepChoice& steps, const Engines& engines,
                State& state) {
  double& length = state.cloth.expected_step;
  const bool starts_step = part.t0 == state.time;
  if (length == 0.0 || (starts_step && state.step % steps_per_measurement == 0)) {
    double stiffest = 1.0;
    for (const double of_rank : results_of_ranks(engines.layout.communicator(), [&] {
           return stiffening_of_rank(*engines.elasticity, engines.team, state.cloth.x);
         }))
      stiffest = std::max(stiffest, of_rank);
    length = share_when_stretched * steps.stable / std::sqrt(stiffest);
  }
  const double share = std::min(length / part.h, 1.0);
  return std::max(static_cast<int>(share * part.length), int{StepPart::least});
}

}  // namespace loomstone
